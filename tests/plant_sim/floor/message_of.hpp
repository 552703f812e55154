#pragma once

#include <gtest/gtest.h>

#include <string>

namespace stillframe::floor::testing {

/// The message of the exception that f throws; the test fails if it throws none of that type.
template <typename Error, typename Function>
std::string message_of(Function&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return {};
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace stillframe::floor::testing
