#include <csignal>
#include <ctime>

#include "msgs/clock.hpp"
#include "tests/controller/controller_process.hpp"

namespace stillframe::controller {
namespace {

void publish_at(toy::FakePlant& plant, std::int64_t k, std::int64_t at_ns) {
  const timespec deadline{.tv_sec = at_ns / ns_per_s, .tv_nsec = at_ns % ns_per_s};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
  plant.publish(plant.measure(k));
}

TEST_F(ControllerProcess, WallClockAnswersTheNewestAndCountsTheRest) {
  constexpr std::int64_t n_samples = 300;
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", n_samples));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns() + 20'000'000;
  plant.publish_state(run_state_t::RUNNING, start);
  // Paced by the clock because that is the mode; how well it is kept is not judged here.
  for (std::int64_t k = 0; k < n_samples; ++k) {
    publish_at(plant, k, start + k * 1'000'000);
    plant.move({1e-3, 0, -1e-3, 0});
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  // The same measurements again: every answer must be the law's, run over those that were answered.
  toy::FakePlant again(plant.info());
  Reference reference(gains);
  size_t answered = 0;
  for (std::int64_t k = 0; k < n_samples && answered < plant.commands.size(); ++k) {
    const measurement_t measurement = again.measure(k);
    again.move({1e-3, 0, -1e-3, 0});
    if (plant.commands[answered].seq != k) continue;
    ASSERT_EQ(plant.command_bytes[answered], reference(measurement)) << "sample " << k;
    ++answered;
  }
  EXPECT_EQ(answered, plant.commands.size());
  EXPECT_GT(answered, 0u);
  EXPECT_EQ(plant.timing->n_lost, n_samples - static_cast<std::int64_t>(answered));
  EXPECT_EQ(plant.timing->n_duplicate, 0);
  // Wake-ups and skipped periods together are the run, and the period in which the end is heard.
  EXPECT_GE(plant.timing->n_periods + plant.timing->n_late, n_samples);
}

TEST_F(ControllerProcess, WallClockSkipsWhatItSleptThrough) {
  constexpr std::int64_t n_samples = 60, period_ns = 1'000'000;
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", n_samples));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns();
  plant.publish_state(run_state_t::RUNNING, start);
  ASSERT_TRUE(plant.exchange(plant.measure(0)));
  controller.suspend();
  const std::int64_t suspended = monotonic_ns();
  for (std::int64_t k = 1; k < n_samples; ++k) publish_at(plant, k, suspended + k * period_ns);
  controller.signal(SIGCONT);
  while (plant.commands.back().seq != n_samples - 1) ASSERT_TRUE(plant.take(5000));
  // One answer, to the newest; a few more if LCM's reading thread was itself slow to catch up.
  EXPECT_LT(plant.commands.size(), 20u);
  plant.publish_state(run_state_t::ENDED);
  const std::int64_t told = monotonic_ns();
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  const std::int64_t ended = monotonic_ns();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  const auto answered =
      static_cast<std::int64_t>(plant.commands.size()) - plant.timing->n_duplicate;
  EXPECT_EQ(plant.timing->n_lost, n_samples - answered);
  EXPECT_GE(plant.timing->worst_wake_up_ns, (n_samples - 2) * period_ns);
  // Every period of the run was either woken for or skipped; the ends are uncertain by one each.
  const std::int64_t periods = plant.timing->n_periods + plant.timing->n_late;
  EXPECT_GE(periods, (told - start) / period_ns - 1);
  EXPECT_LE(periods, (ended - start) / period_ns + 1);
}

}  // namespace
}  // namespace stillframe::controller
