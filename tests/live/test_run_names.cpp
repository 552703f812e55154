#include <gtest/gtest.h>

#include <string>

#include "report/live/run_names.hpp"

namespace stillframe::live {
namespace {

// Texts from the bus that once took the stack or all time: they become a note.
TEST(RunNames, TextsThatAreNoYamlAreANote) {
  std::string bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char name = 'b'; name <= 'm'; ++name) {
    const std::string before = "*" + std::string(1, static_cast<char>(name - 1));
    bomb += std::string(1, name) + ": &" + name + " [";
    for (int i = 0; i < 9; ++i) bomb += before + ", ";
    bomb += before + "]\n";
  }
  for (const std::string& text :
       {std::string("nodes: &a [*a]"), bomb, std::string(100'000, '['), std::string("a: \x1b[2J"),
        std::string("compare: {z: {floor: a, frame: b}, z: {}}")}) {
    stillframe_msgs::run_info_t info{};
    info.leg_names = {"leg"};
    info.n_legs = 1;
    info.scene_text = text;
    EXPECT_FALSE(names_of(info).note.empty());
    info.scene_text.clear();
    EXPECT_TRUE(names_of(info).note.empty());
    info.gains_text = text;
    const RunNames names = names_of(info);
    EXPECT_FALSE(names.note.empty());
    EXPECT_EQ(names.legs, info.leg_names);
    for (const char c : names.note) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
  }
}

}  // namespace
}  // namespace stillframe::live
