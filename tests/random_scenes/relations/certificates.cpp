#include "core/mechanics/certificate.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

std::optional<Finding> check_certificates(Case& scene, std::uint64_t) {
  Finding finding;
  for (const BlockCertificate& block : certify(scene.scene())) {
    finding.take(
        block.difference,
        is_certified(block) ? std::max(certified_difference, block.known_to) : certified_difference,
        block.block);
  }
  return finding;
}

}  // namespace stillframe::random_scenes
