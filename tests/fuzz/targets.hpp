#pragma once

#include <array>
#include <stdexcept>
#include <string_view>

// What reads bytes from outside, each as one function of these bytes. Whatever they are, it
// returns, in bounded time and memory; it throws std::logic_error where a relation does not hold,
// and lets through what no reader may throw. libFuzzer calls them through entry.cpp,
// test_corpus.cpp with every file of corpus/NAME.
namespace stillframe::fuzz {

void scene(std::string_view bytes);   ///< text of a scene
void gains(std::string_view bytes);   ///< text of a gains file; what is accepted decays
void policy(std::string_view bytes);  ///< text of a policy
void messages(
    std::string_view bytes);       ///< which type (the first byte) and the payload of a message
void log(std::string_view bytes);  ///< an LCM log

struct Target {
  const char* name;
  void (*run)(std::string_view bytes);
};

inline constexpr std::array<Target, 5> targets{
    {{"scene", scene}, {"gains", gains}, {"policy", policy}, {"messages", messages}, {"log", log}}};

/// Throws std::logic_error where a relation does not hold.
inline void require(bool holds, const char* relation) {
  if (!holds) throw std::logic_error(relation);
}

}  // namespace stillframe::fuzz
