#include <gtest/gtest.h>

#include <string>

#include "core/errors/input_error.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/floor/recording_file.hpp"
#include "tests/plant_sim/floor/message_of.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::floor {
namespace {

using test::ScratchFolder;
using testing::message_of;

const std::string good_head = "# made for a test\n# fs_hz=10 n=2 units=m/s^2\n";

TEST(RecordingFile, ReadsWhatItSays) {
  const ScratchFolder folder;
  const auto file = read_recording(
      folder.write("a.csv",
                   "# a\r\n# fs_hz=12.5 n=3 units=m/s^2 columns=ax,ay\r\nax,ay\r\n1e-3,-2\r\n"
                   " +0.5 , 4 \r\n7,8\r\n"));
  EXPECT_EQ(file.sample_rate_hz, 12.5);
  EXPECT_EQ(file.columns, (std::vector<std::string>{"ax", "ay"}));
  Eigen::MatrixXd expected(2, 3);
  expected << 1e-3, 0.5, 7, -2, 4, 8;
  EXPECT_EQ(file.acceleration, expected);
}

TEST(RecordingFile, MayBeginWithTheMarkOfUtf8) {
  const ScratchFolder folder;
  const auto file =
      read_recording(folder.write("a.csv", "\xEF\xBB\xBF# fs_hz=10 n=1 units=m/s^2\nax\n1\n"));
  EXPECT_EQ(file.sample_rate_hz, 10.0);
  EXPECT_EQ(file.columns, std::vector<std::string>{"ax"});
}

TEST(RecordingFile, ATimeColumnIsCheckedAndLeftOut) {
  const ScratchFolder folder;
  const auto file = read_recording(folder.write("a.csv", good_head + "time_s,ax\n5.0,1\n5.1,2\n"));
  EXPECT_EQ(file.columns, std::vector<std::string>{"ax"});
  EXPECT_EQ(file.acceleration(0, 1), 2.0);
}

TEST(RecordingFile, TheShippedRecordingsAreSound) {
  const std::string floors = STILLFRAME_SOURCE_DIR "/config/floors/";
  const auto floor = read_recording(floors + "mikb_floor_200hz.csv");
  EXPECT_EQ(floor.sample_rate_hz, 200.0);
  EXPECT_EQ(floor.columns, (std::vector<std::string>{"ax_E", "ay_N", "az_Up"}));
  ASSERT_EQ(floor.acceleration.cols(), 78001);
  // First and last row as they stand in the file.
  EXPECT_EQ(floor.acceleration.col(0), Eigen::Vector3d(-7.6851e-05, 7.7439e-05, 7.1896e-05));
  EXPECT_EQ(floor.acceleration.col(78000), Eigen::Vector3d(5.6424e-05, 4.9553e-06, -2.2973e-04));
  const auto quake = read_recording(floors + "mikb_quake_200hz.csv");
  // The README's peak, 0.194 m/s^2, to its last digit.
  EXPECT_NEAR(worst_of(quake.acceleration), 0.194, 0.0005);
}

struct BadFile {
  const char* name;
  std::string text;
  std::string message;  // behind the path
};

void PrintTo(const BadFile& bad, std::ostream* out) { *out << bad.name; }

class BadRecording : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadRecording, IsRefusedWithFileLineAndColumn) {
  const ScratchFolder folder;
  const auto path = folder.write("bad.csv", GetParam().text);
  EXPECT_EQ(message_of<InputError>([&] { read_recording(path); }),
            path.string() + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, BadRecording,
    ::testing::Values(
        BadFile{"empty", "",
                ":1:1: the file is empty: allowed are comments, a header and rows of numbers"},
        BadFile{"only_comments", good_head,
                ":2:1: the file is empty: allowed are comments, a header and rows of numbers"},
        BadFile{"no_rate", "# n=2 units=m/s^2\nax\n1\n2\n",
                ":2:1: the comment lines above do not say fs_hz=RATE (samples per second)"},
        BadFile{"no_count", "# fs_hz=10 units=m/s^2\nax\n1\n2\n",
                ":2:1: the comment lines above do not say n=ROWS (number of samples)"},
        BadFile{"no_units", "# fs_hz=10 n=2\nax\n1\n2\n",
                ":2:1: the comment lines above do not say units=m/s^2"},
        BadFile{"other_units", "# fs_hz=10 n=2 units=g\nax\n1\n2\n",
                ":1:16: units: found 'g', allowed is m/s^2"},
        BadFile{"zero_rate", "# fs_hz=0 n=2 units=m/s^2\nax\n1\n2\n",
                ":1:3: found 'fs_hz=0', allowed is fs_hz=RATE, a number above 0"},
        BadFile{"rate_is_a_word", "# fs_hz=fast n=2 units=m/s^2\nax\n1\n2\n",
                ":1:3: found 'fs_hz=fast', allowed is fs_hz=RATE, a number above 0"},
        BadFile{"part_of_a_row", "# fs_hz=10 n=1.5 units=m/s^2\nax\n1\n2\n",
                ":1:12: found 'n=1.5', allowed is n=ROWS, a whole number above 0"},
        BadFile{"rate_twice", "# fs_hz=10 n=2 units=m/s^2\n# fs_hz=20\nax\n1\n2\n",
                ":2:3: 'fs_hz=20' is said twice"},
        BadFile{"header_is_a_row", good_head + "1,2\n3,4\n",
                ":3:1: header: found '1', allowed is a column name"},
        BadFile{"name_twice", good_head + "ax,ay,ax\n1,2,3\n4,5,6\n",
                ":3:7: header: 'ax' stands twice"},
        BadFile{"nameless", good_head + "ax,\n1,2\n3,4\n",
                ":3:4: header: found '', allowed is a column name"},
        BadFile{"other_columns", "# fs_hz=10 n=1 units=m/s^2 columns=ax,ay\nay,ax\n1,2\n",
                ":2:1: header: found 'ay,ax', but the comment says columns=ax,ay"},
        BadFile{"only_time", good_head + "time_s\n0\n0.1\n",
                ":3:1: header: allowed is at least one axis beside time_s"},
        BadFile{"no_rows", good_head + "ax\n", ":3:1: no rows of numbers follow the header"},
        BadFile{"nan", good_head + "ax,ay\n1,2\n3, nan\n",
                ":5:4: ay: found 'nan', allowed is a finite number"},
        BadFile{"infinite", good_head + "ax,ay\n-inf,2\n3,4\n",
                ":4:1: ax: found '-inf', allowed is a finite number"},
        BadFile{"word", good_head + "ax,ay\n1,2\n3,4x\n",
                ":5:3: ay: found '4x', allowed is a finite number"},
        BadFile{"nothing_that_a_terminal_obeys", good_head + "a\x1b[2J\n1\n4\x1b[2J\n",
                ":5:1: a\\x1b[2J: found '4\\x1b[2J', allowed is a finite number"},
        BadFile{"a_byte_that_is_zero", good_head + "ax\n1\n" + std::string(1, '\0') + "7\n",
                ":5:1: ax: found '\\x007', allowed is a finite number"},
        BadFile{"long_cell", good_head + "ax\n1\n" + std::string(1 << 20, 'z') + "\n",
                ":5:1: ax: found '" + std::string(80, 'z') + "...', allowed is a finite number"},
        BadFile{"long_names",
                "# fs_hz=10 n=2 units=m/s^2 columns=" + std::string(1 << 20, 'y') + "\n" +
                    std::string(1 << 20, 'z') + "\n1\n2\n",
                ":2:1: header: found '" + std::string(80, 'z') +
                    "...', but the comment says columns=" + std::string(80, 'y') + "..."},
        BadFile{"hole", good_head + "ax,ay\n1,2\n,4\n",
                ":5:1: ax: found '', allowed is a finite number"},
        BadFile{"short_row", good_head + "ax,ay,az\n1,2,3\n4,5\n",
                ":5:3: found 2 columns, allowed is 3 as in the header"},
        BadFile{"long_row", good_head + "ax,ay\n1,2\n4,5,6\n",
                ":5:5: found 3 columns, allowed is 2 as in the header"},
        BadFile{"lost_row", good_head + "ax\n1\n",
                ":4:1: the rows end here after 1, but the comment says n=2: samples are missing or "
                "too many"},
        BadFile{"row_too_many", good_head + "ax\n1\n2\n3\n",
                ":6:1: the rows end here after 3, but the comment says n=2: samples are missing or "
                "too many"},
        BadFile{"gap_in_time", good_head + "ax,time_s\n1,5.0\n2,5.2\n",
                ":5:3: time_s: found 5.2, allowed is 5.1 (even steps of 1/fs_hz, no gaps)"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(RecordingFile, AMissingFileOrAFolderIsRefused) {
  const ScratchFolder folder;
  const auto missing = (folder.path() / "none.csv");
  EXPECT_EQ(message_of<InputError>([&] { read_recording(missing); }),
            missing.string() + ": no such file, or not readable; a recording (CSV) is needed");
  EXPECT_EQ(
      message_of<InputError>([&] { read_recording(folder.path()); }),
      folder.path().string() + ": no such file, or not readable; a recording (CSV) is needed");
}

}  // namespace
}  // namespace stillframe::floor
