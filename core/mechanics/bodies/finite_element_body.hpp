#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace stillframe {

/// A body of solid elements as another program has meshed it: every degree of freedom is the
/// displacement of a node along an axis.
struct FiniteElementBody {
  std::string name;                                  ///< of the files
  std::map<long, Eigen::Vector3d> nodes;             ///< m, by their numbers in the mesh
  std::map<std::string, std::vector<long>> sets;     ///< of nodes; names in capitals
  std::map<long, std::array<Eigen::Index, 3>> rows;  ///< of a node's displacements, -1: held
  Eigen::SparseMatrix<double> M, K;                  ///< kg, N/m; symmetric, both triangles
};

/// Reads what CalculiX writes of a job with `*FREQUENCY, SOLVER=MATRIXSTORAGE`: JOB.sti, JOB.mas
/// and JOB.dof, and nodes and sets of nodes (*NODE, *NSET, *INCLUDE) from JOB.inp. Errors:
/// InputError with file, line, what was found and what is allowed.
FiniteElementBody read_calculix(
    const std::filesystem::path& job,
    const std::function<void(const std::string&)>& stage = [](auto&) {});

/// A set by its name, in any case of letters. Errors: InputError naming the nearest one.
const std::vector<long>& node_set(const FiniteElementBody& body, const std::string& name,
                                  const std::string& place);

}  // namespace stillframe
