#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>

namespace stillframe {

/// How far loads could be followed from zero.
struct LoadPath {
  double reached = 0;  ///< of their size, 1: all
  int attempts = 0, iterations = 0, load_steps = 1;
};

/// Attempts at a load. The hardest paths that lead somewhere take some hundred.
inline constexpr int most_attempts = 1000;

/// What follows needs of a balance of forces: its unknowns are a State, which state() gives and
/// return_to() takes;
///   set_factor(f)    the load factor from now on
///   forces()         what is out of balance there; false if the position cannot be reached
///   solve()          the step of Newton's method from there
///   length()         how far the nodes go in it, beside the size of the scene as written
///   length_now()     the same beside its size as it is now
///   take()           goes that step, then as forces()
///   holds()          whether nothing but rounding is out of balance
///   n_negative()     in how many directions the stiffness of the last step pushes on what moves
///   position(state)  the displacements in a State
///   way(x)           how far a displacement goes, as length()
///
/// Newton's method at one load factor, from the balance's position. The second step may be a
/// twentieth of the first at most: then all that is not linear on the way is small beside what is,
/// and no other equilibrium, nor a load at which this one ends, lies between; after that, each may
/// be a quarter of the one before (Newton and Kantorovich). Lengths are those of the nodes, so that
/// units and the choice of dofs do not matter. The first step may grow with the scene, so that a
/// long pull takes no more of them than its logarithm; the second may not.
template <class Balance>
bool contracts(Balance& balance, int& iterations) {
  constexpr double at_first = 0.05, most = 0.25;
  constexpr double farthest = 0.5;   // rad, or of the scene's size: more is a guess
  constexpr double rounding = 1e-7;  // as far as rounding may leave an ill-conditioned balance
  if (!balance.forces()) return false;
  double longest = 0;
  for (int k = 0;; ++k) {
    if (!balance.solve()) return false;
    if (k == 0 && !(balance.length_now() <= farthest)) return false;
    const double length = balance.length();
    if (k > 0 && !(length <= longest)) return longest <= rounding && balance.holds();
    ++iterations;
    if (!balance.take()) return false;
    if (length == 0) return balance.holds();
    longest = k == 0 ? at_first * std::min(length, farthest) : most * length;
  }
}

/// One load factor; the balance stays where it was if there is no equilibrium near.
template <class Balance>
bool balance_at(Balance& balance, double factor, int& iterations) {
  const auto start = balance.state();
  balance.set_factor(factor);
  if (contracts(balance, iterations)) return true;
  balance.return_to(start);
  return false;
}

/// Follows the loads from zero, in one step or in as many as Newton's method needs to contract from
/// its start in each. Where stiffness grows with the loads themselves, not with what they have
/// moved, it can be negative beyond a load at which the path turns away from there: so what is
/// unstable in more directions than the path has been is reached only where the path itself goes
/// through, as that of a straight column does: in a small step, where the step before was heading.
/// The balance stays at the last load that was reached.
template <class Balance>
LoadPath follow_loads(Balance& balance) {
  LoadPath path;
  double step = 1, last_step = 0;
  Eigen::VectorXd last_move;
  Eigen::Index most_negative = 0;
  // Towards a limit load steps shrink as what is left of it does, to a tenth or so; 2^-16 of the
  // load is where the path has ended. The first step may be as small as a load is large.
  const auto least = [&] { return path.reached > 0 ? 0x1p-16 * path.reached : 0x1p-40; };
  // Where a path turns away what has moved most of late is on the other side on another branch.
  const auto goes_through = [&](const Eigen::VectorXd& move) {
    if (path.reached == 0) return 0.5 * step < least();
    const Eigen::VectorXd expected = step / last_step * last_move;
    return step <= 0x1p-8 * path.reached &&
           balance.way(move - expected) <= 0.5 * balance.way(expected);
  };
  while (path.reached < 1 && step >= least() && path.attempts < most_attempts) {
    ++path.attempts;
    const double factor = std::min(1.0, path.reached + step);
    const auto start = balance.state();
    bool taken = balance_at(balance, factor, path.iterations);
    const Eigen::VectorXd move = balance.position(balance.state()) - balance.position(start);
    if (taken && balance.n_negative() > most_negative) {
      taken = goes_through(move);
      if (taken) {
        most_negative = balance.n_negative();
      } else {
        balance.return_to(start);
      }
    }
    if (taken) {
      last_step = factor - path.reached;
      last_move = move;
      path.reached = factor;
      step *= 2;
      if (path.reached < 1) ++path.load_steps;
    } else {
      step *= step == 1.0 ? 0.125 : 0.5;
    }
  }
  return path;
}

/// Refuses loads of which not all could be followed, but some: to where, and what has moved most
/// (in words, or empty) there.
[[noreturn]] void refuse_load(const LoadPath& path, const std::string& moved);

/// Refuses loads of which not even a small part could be: for what nothing resists, or for no
/// reason that is known (empty).
[[noreturn]] void refuse_any_load(const std::string& unresisted);

}  // namespace stillframe
