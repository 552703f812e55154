#include "controller/policy.hpp"

#include <array>

namespace stillframe::controller {

namespace {

using std::string_view_literals::operator""sv;

constexpr std::array defect_names{"none"sv, "missing"sv, "late"sv, "not_finite"sv,
                                  "out_of_range"sv};
constexpr std::array fault_names{"none"sv,       "silence"sv,      "losses"sv,   "suspended"sv,
                                 "not_finite"sv, "out_of_range"sv, "restless"sv, "law_not_finite"sv,
                                 "not_alive"sv,  "offset"sv,       "limited"sv,  "noisy"sv,
                                 "unheard"sv,    "disobeyed"sv};
static_assert(defect_names.size() == static_cast<std::size_t>(Defect::out_of_range) + 1);
static_assert(fault_names.size() == static_cast<std::size_t>(Fault::disobeyed) + 1);

template <std::size_t n>
std::string_view name_of(std::int32_t value, const std::array<std::string_view, n>& names) {
  const auto i = static_cast<std::size_t>(value);
  return i < n ? names[i] : "unknown";
}

}  // namespace

std::string_view to_text(Defect defect) noexcept {
  return name_of(static_cast<std::int32_t>(defect), defect_names);
}

std::string_view to_text(Fault fault) noexcept {
  return name_of(static_cast<std::int32_t>(fault), fault_names);
}

Policy::Realtime realtime_named(std::string_view word) noexcept {
  return word == "off"       ? Policy::Realtime::off
         : word == "enforce" ? Policy::Realtime::enforce
                             : Policy::Realtime::best_effort;
}

}  // namespace stillframe::controller
