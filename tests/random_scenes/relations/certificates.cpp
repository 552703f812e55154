#include "core/certificate.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

std::optional<Finding> check_certificates(Case& scene, std::uint64_t) {
  Finding finding;
  for (const BlockCertificate& block : certify(scene.scene())) {
    finding.take(block.difference, std::max(certified_difference, block.known_to), block.block);
    finding.take(block.known_to, 1e-5, block.block + " known to");
  }
  return finding;
}

}  // namespace stillframe::random_scenes
