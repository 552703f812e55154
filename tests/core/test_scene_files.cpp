#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/core/bad_scenes.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::test {
namespace {

class SceneFiles : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static std::string error_of_file(const std::filesystem::path& file) {
    try {
      read_scene(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const ScratchFolder scratch_;
  const std::filesystem::path& folder_ = scratch_.path();
};

TEST_F(SceneFiles, MissingFilesAndFoldersAreNamed) {
  const auto missing = folder_ / "nowhere.yaml";
  EXPECT_EQ(error_of_file(missing),
            missing.string() + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_of_file(folder_), folder_.string() + ": is a folder, a YAML file is needed");
  EXPECT_EQ(error_of_file(write("empty.yaml", "")),
            (folder_ / "empty.yaml").string() + ": cannot be read: it is empty");
}

// Whether there is a file at the end of it cannot be found out, which is neither yes nor no.
TEST_F(SceneFiles, LoopsOfLinksAndNamesThatAreTooLongAreRefused) {
  std::filesystem::create_symlink("b", folder_ / "a");
  std::filesystem::create_symlink("a", folder_ / "b");
  std::filesystem::create_symlink("itself", folder_ / "itself");
  const size_t from = sound_scene.find("controller:\n"), to = sound_scene.find("simulation:");
  for (const std::string& name :
       std::vector<std::string>{"a", "itself", "a/scene.yaml", std::string(300, 'n')}) {
    SCOPED_TRACE(name);
    const std::string path = (folder_ / name).string();
    // A controller block, and what is no YAML: a matrix, a law, a recording.
    const std::string scene =
        std::string(sound_scene).replace(from, to - from, "controller: " + name + "\n");
    const auto why =
        std::make_error_code(name.size() > 255 ? std::errc::filename_too_long
                                               : std::errc::too_many_symbolic_link_levels)
            .message();
    EXPECT_EQ(error_of_file(path), path + ": cannot be read: " + why);
    EXPECT_EQ(error_of_file(write("scene.yaml", scene)), (folder_ / "scene.yaml").string() +
                                                             ":31:13: controller: the file '" +
                                                             path + "' cannot be read: " + why);
    try {
      YamlReader::from_text("file: " + name + "\n", "scene.yaml", folder_)
          .require("file")
          .file_bytes(1000);
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(),
                "scene.yaml:1:7: file: the file '" + path + "' cannot be read: " + why);
    }
  }
}

TEST_F(SceneFiles, AControllerInAFileOfItsOwnIsReadAndItsErrorsAreThere) {
  const size_t from = sound_scene.find("controller:\n"), to = sound_scene.find("simulation:");
  const std::string scene =
      std::string(sound_scene).replace(from, to - from, "controller: law.yaml\n");
  const auto file = write("scene.yaml", scene);
  EXPECT_NE(error_of_file(file).find("scene.yaml:31:13: controller: the file '" +
                                     (folder_ / "law.yaml").string() + "' does not exist"),
            std::string::npos)
      << error_of_file(file);
  const std::string law =
      "legs: [leg_1]\ntarget_hz: 5\ndamping_ratio: 0.7\nsample_rate_hz: 1000\n"
      "delay_samples: 0\nleak_hz: 0\n";
  write("law.yaml", law);
  const Scene read = read_scene(file);
  ASSERT_TRUE(read.controller.has_value());
  EXPECT_EQ(read.controller->sample_rate_hz, 1000);
  EXPECT_EQ(read.hash, text_hash(scene + law));
  write("law.yaml", "legs: [leg_1]\ntarget_hz: five\n");
  EXPECT_NE(error_of_file(file).find("law.yaml:2:12: target_hz: found 'five'"), std::string::npos)
      << error_of_file(file);
  // A file given beside the scene replaces what stands in it.
  const Scene replaced =
      read_scene(write("inline.yaml", sound_scene), write("other.yaml", changed(law, "5", "7")));
  EXPECT_EQ(replaced.controller->lowest_target_hz(), 7);
  // Gains are stale as soon as the controller block changes, wherever it stands.
  write("law.yaml", changed(law, "5", "7"));
  EXPECT_NE(read_scene(file).hash, read.hash);
}

// A log keeps the text, and whoever reads it looks from another folder.
TEST_F(SceneFiles, TheTextWithFullPathsFindsRecordingsFromAnywhere) {
  const std::string head = std::string(sound_scene) + "disturbances:\n";
  const auto force = [](const std::string& name, const std::string& file) {
    return "- {name: " + name + ", node: tip, along: z, force: {recording: {file: " + file +
           ", column: f}}}  # as measured\n";
  };
  const std::string step = "- {name: push, node: tip, along: z, force: {step: {height: 1}}}\n";
  const std::string own = (folder_ / "a.csv").string(),
                    up = (folder_.parent_path() / "b \xC3\xA9.csv").string();
  const auto given = [&](const std::string& begin) {
    return begin + head + force("plain", "a.csv") + step + force("single", "'../b \xC3\xA9.csv'") +
           force("double", "\"a.csv\"") + force("full", own) +
           "- name: block\n  node: tip\n  along: z\n  force:\n    recording:\n"
           "      file: a.csv  # beside it\n      column: f\n";
  };
  const std::string quoted = '"' + own + '"';
  for (const std::string begin : {"", "# \xC3\xA9\n", "\xEF\xBB\xBF"}) {
    const Scene scene = read_scene(std::filesystem::relative(write("scene.yaml", given(begin))));
    const std::string kept = text_with_full_paths(scene);
    // Nothing but the paths differs.
    EXPECT_EQ(kept, begin + head + force("plain", quoted) + step + force("single", '"' + up + '"') +
                        force("double", quoted) + force("full", own) +
                        "- name: block\n  node: tip\n  along: z\n  force:\n    recording:\n"
                        "      file: " +
                        quoted + "  # beside it\n      column: f\n");
    EXPECT_EQ(scene.text, given(begin));
    for (const SceneDisturbance& disturbance : parse_scene(kept, "log").disturbances) {
      const auto* recording = std::get_if<ForceRecording>(&disturbance.force);
      if (recording) {
        EXPECT_EQ(recording->file, disturbance.name == "single" ? up : own);
      }
    }
  }
  // Escapes are read; a path relative to a folder that a log does not know would be lost in it.
  const std::string escaped = head + force("escaped", R"("\x61.csv")");
  EXPECT_THROW(text_with_full_paths(read_scene(write("scene.yaml", escaped))), InputError);
}

TEST(SceneText, HashIsFnv1a) {
  EXPECT_EQ(text_hash(""), "cbf29ce484222325");  // published test vectors of FNV-1a, 64 bit
  EXPECT_EQ(text_hash("a"), "af63dc4c8601ec8c");
  EXPECT_EQ(text_hash("foobar"), "85944171f73967e8");
}

TEST(SceneText, NumbersMayBeWrittenInAnyUsualWay) {
  for (const char* text : {"4", "+4", "4.0", "4e0", "4.", "400e-2"}) {
    EXPECT_EQ(parse_scene(changed(sound_scene, "mass: 4", std::string("mass: ") + text), "s")
                  .masses.front()
                  .mass,
              4)
        << text;
  }
}

}  // namespace
}  // namespace stillframe::test
