#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene_blocks.hpp"

namespace stillframe::tools {

/// One key of a scene and the values that it takes, as they are written.
struct SweptKey {
  std::string path;  ///< "controller.target_hz", "elements.leg_*.stiffness"
  std::vector<std::string> values;
};

/// Of "PATH=a,b,c", or of so many numbers between two: "PATH=from:to:count", equally far apart, or
/// "PATH=from:to:count:log", by equal factors. Errors: InputError.
SweptKey parse_swept_key(const std::string& text);

/// Every combination of the values of some keys, the last key the fastest.
class SweepGrid {
 public:
  /// Errors: InputError for a key that is given twice, and for more than a million points.
  explicit SweepGrid(std::vector<SweptKey> keys);

  const std::vector<SweptKey>& keys() const { return keys_; }
  std::size_t size() const { return size_; }
  /// Of point i, one a key.
  std::vector<std::string> values(std::size_t i) const;

 private:
  std::vector<SweptKey> keys_;
  std::size_t size_ = 1;
};

/// The same blocks with other values, in all places that each path names: keys of maps, of lists
/// the item of that node or name or number (from 1), and of either * for any part of a name. A path
/// that begins with "controller" goes on in the controller block, wherever that is written. Errors:
/// InputError for a path that names no value that is written there.
SceneBlocks with_values(SceneBlocks blocks, const std::vector<SweptKey>& keys,
                        const std::vector<std::string>& values);

}  // namespace stillframe::tools
