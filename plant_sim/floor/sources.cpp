#include "plant_sim/floor/sources.hpp"

#include <algorithm>
#include <stdexcept>

namespace stillframe::floor {

bool TabulatedFloor::moves(Eigen::Index channel) const {
  for (Eigen::Index i = 0; i < courses_.rows(); ++i) {
    if (patterns_(channel, i) != 0 && !courses_.row(i).isZero(0)) return true;
  }
  return false;
}

SumFloor::SumFloor(std::vector<std::unique_ptr<FloorSource>> parts, Eigen::Index inputs) {
  if (parts.empty()) throw std::invalid_argument("SumFloor: expected one part or more, got none");
  bool rigid = false, single = false;
  for (const auto& part : parts) {
    rigid |= part->meaning() != FloorChannels::inputs;
    single |= part->meaning() == FloorChannels::inputs;
  }
  meaning_ = !single ? FloorChannels::rigid
             : rigid ? FloorChannels::rigid_and_inputs
                     : FloorChannels::inputs;
  channels_ = (rigid ? 6 : 0) + (single ? inputs : 0);
  for (auto& part : parts) {
    const Eigen::Index offset = rigid && part->meaning() == FloorChannels::inputs ? 6 : 0;
    n_samples_ = std::max(n_samples_, part->n_samples());
    parts_.push_back({std::move(part), offset});
  }
}

bool SumFloor::moves(Eigen::Index channel) const {
  return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
    const Eigen::Index i = channel - part.offset;
    return i >= 0 && i < part.source->channels() && part.source->moves(i);
  });
}

void SumFloor::add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept {
  for (const Part& part : parts_) {
    part.source->add(k, out.segment(part.offset, part.source->channels()));
  }
}

}  // namespace stillframe::floor
