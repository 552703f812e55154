// docs/architecture.md against the sources: who includes whom, and that what it points at is there.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path source_dir = STILLFRAME_SOURCE_DIR;

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) {
    const auto first = cell.find_first_not_of(' ');
    cells.push_back(first == std::string::npos
                        ? ""
                        : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
  }
  return cells;
}

using Rooms = std::map<std::string, std::set<std::string>>;

/// Each room of the table "The rooms" with those it may use.
Rooms rooms_of_the_map() {
  Rooms rooms;
  bool inside = false;
  for (const std::string& line : lines_of(source_dir / "docs/architecture.md")) {
    if (line.rfind("## ", 0) == 0) inside = line == "## The rooms";
    if (!inside || line.rfind("| ", 0) != 0) continue;
    const auto cells = cells_of(line);
    if (cells.size() != 3 || cells[0] == "room") continue;
    std::istringstream names(cells[2]);
    std::set<std::string>& allowed = rooms[cells[0]];
    for (std::string name; std::getline(names, name, ',');) {
      allowed.insert(name.substr(name.find_first_not_of(' ')));
    }
  }
  return rooms;
}

/// The innermost room a path is in; empty: none.
std::string room_of(const Rooms& rooms, fs::path path) {
  for (path = path.parent_path(); !path.empty(); path = path.parent_path()) {
    if (rooms.count(path.generic_string()) != 0) return path.generic_string();
  }
  return "";
}

bool is_source(const fs::path& file) {
  return file.extension() == ".cpp" || file.extension() == ".hpp";
}

std::vector<std::string> project_includes(const fs::path& file) {
  static const std::regex include("#include \"([^\"]+)\"");
  std::vector<std::string> found;
  std::smatch match;
  for (const std::string& line : lines_of(file)) {
    if (std::regex_search(line, match, include)) found.push_back(match[1]);
  }
  return found;
}

struct Include {
  std::string file, room, used_room;
};

std::vector<Include> includes_between(const Rooms& rooms) {
  std::vector<Include> found;
  for (const char* top : {"core", "msgs", "controller", "plant_sim", "report", "judge", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(source_dir / top)) {
      if (!is_source(entry.path())) continue;
      const fs::path file = fs::relative(entry.path(), source_dir);
      const std::string room = room_of(rooms, file);
      EXPECT_NE(room, "") << file << " is in no room of docs/architecture.md";
      for (const std::string& used : project_includes(entry.path())) {
        const std::string used_room = room_of(rooms, used);
        if (!used_room.empty() && used_room != room) {
          found.push_back({file.generic_string() + " includes " + used, room, used_room});
        }
      }
    }
  }
  return found;
}

TEST(House, RoomsIncludeWhatTheMapAllows) {
  const Rooms rooms = rooms_of_the_map();
  ASSERT_GE(rooms.size(), 15u);
  std::set<std::string> seen;
  for (const Include& include : includes_between(rooms)) {
    EXPECT_EQ(rooms.at(include.room).count(include.used_room), 1u) << include.file;
    seen.insert(include.room + " " + include.used_room);
  }
  // What nobody uses is not allowed either: a map of doors that are not there.
  for (const auto& [room, allowed] : rooms) {
    for (const std::string& used : allowed) {
      EXPECT_EQ(seen.count(room + " " + used), 1u) << room << " does not use " << used;
    }
  }
}

TEST(House, NoTwoRoomsIncludeEachOtherInACircle) {
  const Rooms rooms = rooms_of_the_map();
  // Rooms leave one after the other whose every used room has left; in a circle none can.
  std::set<std::string> left;
  bool found = true;
  while (found) {
    found = false;
    for (const auto& [room, allowed] : rooms) {
      if (left.count(room) != 0) continue;
      if (!std::includes(left.begin(), left.end(), allowed.begin(), allowed.end())) continue;
      left.insert(room);
      found = true;
    }
  }
  for (const auto& [room, allowed] : rooms) {
    EXPECT_EQ(left.count(room), 1u) << room << " is in a circle, or uses a room that is not named";
  }
}

TEST(House, WhatTheMapPointsAtIsThere) {
  static const std::regex path("`([a-z_]+/[A-Za-z_/.]*)`");
  int n = 0;
  for (const std::string& line : lines_of(source_dir / "docs/architecture.md")) {
    for (std::sregex_iterator it(line.begin(), line.end(), path), end; it != end; ++it, ++n) {
      EXPECT_TRUE(fs::exists(source_dir / (*it)[1].str())) << (*it)[1];
    }
  }
  EXPECT_GE(n, 30);
}

}  // namespace
