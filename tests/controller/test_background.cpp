#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <semaphore>
#include <stdexcept>
#include <vector>

#include "controller/background.hpp"

namespace stillframe::controller {
namespace {

constexpr double long_s = 600;  // of a test that hangs

/// A job that hangs until it is let go.
struct Hanging {
  std::shared_ptr<std::binary_semaphore> begun = std::make_shared<std::binary_semaphore>(0),
                                         free = std::make_shared<std::binary_semaphore>(0);
  void operator()() const {
    begun->release();
    free->acquire();
  }
};

TEST(Background, DoesJobsInTheirOrderWhateverTheyThrow) {
  Background background(1000);
  const auto done = std::make_shared<std::vector<int>>();
  for (int i = 0; i < 500; ++i) {
    background.give([done, i] {
      done->push_back(i);
      if (i % 3 == 0) throw std::runtime_error("a full disk");
    });
  }
  ASSERT_TRUE(background.finish(long_s));
  ASSERT_EQ(done->size(), 500u);
  for (int i = 0; i < 500; ++i) EXPECT_EQ(done->at(static_cast<size_t>(i)), i);
  EXPECT_EQ(background.n_dropped(), 0);
}

TEST(Background, NeverWaitsForAJobThatHangsAndDropsTheOldest) {
  Background background(3);
  const Hanging hanging;
  background.give(hanging);
  hanging.begun->acquire();
  const auto done = std::make_shared<std::vector<int>>();
  for (int i = 0; i < 10; ++i) background.give([done, i] { done->push_back(i); });
  EXPECT_FALSE(background.finish(0));
  EXPECT_EQ(background.n_dropped(), 7);
  hanging.free->release();
  ASSERT_TRUE(background.finish(long_s));
  EXPECT_EQ(*done, (std::vector{7, 8, 9}));
}

TEST(Background, CanBeLeftWhileAJobHangs) {
  const Hanging hanging;
  const auto after = std::make_shared<std::binary_semaphore>(0);
  {
    Background background(3);
    background.give(hanging);
    hanging.begun->acquire();
    background.give([after] { after->release(); });
  }
  hanging.free->release();
  after->acquire();
}

}  // namespace
}  // namespace stillframe::controller
