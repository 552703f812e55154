#pragma once

#include <cstdint>

#include "core/yaml/reader.hpp"

// Numbers with both ends. Errors: InputError with what was found and what is allowed.
namespace stillframe {

/// From lowest to highest.
double number_within(const YamlReader& value, double lowest, double highest);
std::int64_t integer_within(const YamlReader& value, std::int64_t lowest, std::int64_t highest);

/// Above 0 and up to highest.
double positive_up_to(const YamlReader& value, double highest);

}  // namespace stillframe
