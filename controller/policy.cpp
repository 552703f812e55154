#include "controller/policy.hpp"

namespace stillframe::controller {

std::string_view to_text(Defect defect) noexcept {
  switch (defect) {
    case Defect::none:
      return "none";
    case Defect::missing:
      return "missing";
    case Defect::late:
      return "late";
    case Defect::not_finite:
      return "not_finite";
    case Defect::out_of_range:
      return "out_of_range";
  }
  return "unknown";
}

std::string_view to_text(Fault fault) noexcept {
  switch (fault) {
    case Fault::none:
      return "none";
    case Fault::silence:
      return "silence";
    case Fault::losses:
      return "losses";
    case Fault::suspended:
      return "suspended";
    case Fault::not_finite:
      return "not_finite";
    case Fault::out_of_range:
      return "out_of_range";
    case Fault::restless:
      return "restless";
    case Fault::law_not_finite:
      return "law_not_finite";
    case Fault::not_alive:
      return "not_alive";
    case Fault::offset:
      return "offset";
    case Fault::limited:
      return "limited";
    case Fault::noisy:
      return "noisy";
    case Fault::unheard:
      return "unheard";
    case Fault::disobeyed:
      return "disobeyed";
  }
  return "unknown";
}

}  // namespace stillframe::controller
