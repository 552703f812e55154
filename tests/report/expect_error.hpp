#pragma once

#include <gtest/gtest.h>

#include <string>

namespace stillframe::report {

/// Expects that `action` throws an Error whose message contains `part`.
template <typename Error, typename Action>
void expect_error(Action&& action, const std::string& part) {
  try {
    action();
    ADD_FAILURE() << "nothing was thrown, expected: " << part;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << "found: " << error.what();
  }
}

}  // namespace stillframe::report
