#include "tests/random_scenes/relation.hpp"

#include <cmath>
#include <limits>

namespace stillframe::random_scenes {

// Each in its file of relations/.
std::optional<Finding> check_frequencies(Case& scene, std::uint64_t seed);
std::optional<Finding> check_sparse(Case& scene, std::uint64_t seed);
std::optional<Finding> check_reduction(Case& scene, std::uint64_t seed);
std::optional<Finding> check_placement(Case& scene, std::uint64_t seed);
std::optional<Finding> check_renumbering(Case& scene, std::uint64_t seed);
std::optional<Finding> check_units(Case& scene, std::uint64_t seed);
std::optional<Finding> check_dofs(Case& scene, std::uint64_t seed);
std::optional<Finding> check_certificates(Case& scene, std::uint64_t seed);
std::optional<Finding> check_small_motion(Case& scene, std::uint64_t seed);
std::optional<Finding> check_stability(Case& scene, std::uint64_t seed);
std::optional<Finding> check_margins(Case& scene, std::uint64_t seed);
std::optional<Finding> check_methods(Case& scene, std::uint64_t seed);
std::optional<Finding> check_report(Case& scene, std::uint64_t seed);

double Finding::share() const {
  if (value == 0 && bound >= 0) return 0;
  const double share = value / bound;
  return std::isnan(share) ? std::numeric_limits<double>::infinity() : share;
}

void Finding::take(double other_value, double other_bound, const std::string& other_what,
                   double size) {
  ++compared;
  if (!(other_bound <= 0.1 * size)) ++unknown;
  const Finding other{other_value, other_bound, other_what, compared, unknown, skipped};
  if (what.empty() || other.share() > share()) *this = other;
}

bool skips(Finding& finding, const std::string& what, double cost, double most) {
  if (cost <= most) return false;
  finding.skipped.push_back(what);
  return true;
}

bool too_short(Finding& finding, const std::string& run, std::int64_t n, std::int64_t all) {
  // Most floors begin within ten samples, the loop answers one to four later.
  constexpr std::int64_t fewest = 20;
  if (n == all) return false;
  finding.skipped.push_back(n < fewest ? run : (2 * n < all ? "most of " : "the end of ") + run);
  return n < fewest;
}

const std::vector<Relation>& relations() {
  static const std::vector<Relation> all = {
      {"frequencies", "minimal dofs against nodal coordinates with constraints", check_frequencies},
      {"sparse", "minimal dofs against displacements and stresses that are both unknown",
       check_sparse},
      {"reduction", "no further from the whole model than the bound of a reduced one says",
       check_reduction},
      {"placement", "turned and shifted", check_placement},
      {"renumbering", "another order, other names", check_renumbering},
      {"units", "another metre, kilogram and second", check_units},
      {"dofs", "other coordinates", check_dofs},
      {"certificates", "matrices are derivatives of the nonlinear equations", check_certificates},
      {"small_motion", "nonlinear less linear motion falls as the square of the amplitude",
       check_small_motion},
      {"stability", "what the design calls stable decays, what it calls unstable grows",
       check_stability},
      {"margins", "just inside is stable, just outside is not", check_margins},
      {"methods", "methods of the plant agree within 30 tolerances", check_methods},
      {"report", "no NaN in report and exports, which are what the run shows directly",
       check_report},
  };
  return all;
}

}  // namespace stillframe::random_scenes
