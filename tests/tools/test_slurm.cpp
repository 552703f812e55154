#include <cstdlib>
#include <fstream>

#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

/// A cluster of one node that Slurm runs, for a script of sh; skipped where there is none.
class OnSlurm : public Verb {
 protected:
  void on_slurm(const std::string& script) const {
    // wait_for_all: until the queue is empty, for two minutes at most.
    write("script.sh",
          "set -e\n"
          "export BIN=" STILLFRAME_BIN_DIR
          "\n"
          "wait_for_all() { for _ in $(seq 1200); do squeue --noheader > queue; test -s queue || "
          "return 0; sleep 0.1; done; cat queue; tail -n 3 slurm/*.log; return 1; }\n"
          "cd " +
              folder_.string() + "\n" + script);
    const Said said =
        shell(std::string(STILLFRAME_SOURCE_DIR) + "/tests/tools/with_slurm " +
              (folder_ / "slurm").string() + " sh " + (folder_ / "script.sh").string());
    if (said.exit_code == 77) GTEST_SKIP() << "needs slurm-wlm, munge and root";
    ASSERT_EQ(said.exit_code, 0) << said.output << said.error;
  }

  Json rows_of(const std::vector<std::string>& arguments) const {
    Json document = json(arguments);
    for (Json& row : document.is_array() ? document : document["rows"]) {
      row.erase("real_time_factor");
    }
    return document;
  }

  const std::string frame_ = config("scenes/metrology_frame.yaml").string();
};

/// What the tasks and the job after them leave is what one program makes; rows that are missing are
/// had by the same command again.
TEST_F(OnSlurm, ASweepInTasksIsTheSweepInOneProgramAndGoesOnWhereItStopped) {
  const std::vector<std::string> call{"sweep", frame_, "--set", "controller.target_hz=3:6:7",
                                      "--at",  "10,50"};
  const Json whole = rows_of(call);
  const std::string on = "$BIN/stillframe sweep " + frame_ +
                         " --set controller.target_hz=3:6:7 --at 10,50 --out 'all rows.jsonl' "
                         "--jobs=1 --json --on slurm:3\n";
  on_slurm(on +
           "wait_for_all\n"
           "test $(wc -l < 'all rows.jsonl') = 7\n"
           "test -z \"$(ls | grep part_)\"\n"
           // Two rows are kept, one of them half: six are missing.
           "head -c $(( $(head -n 1 'all rows.jsonl' | wc -c) + 30 )) 'all rows.jsonl' > kept\n"
           "mv kept 'all rows.jsonl'\n" +
           on + "wait_for_all\ntest $(wc -l < 'all rows.jsonl') = 7\n");
  if (IsSkipped() || HasFatalFailure()) return;
  auto table = call;
  const std::string rows = text_of(folder_ / "all rows.jsonl");
  table.insert(table.end(), {"--out", (folder_ / "all rows.jsonl").string()});
  EXPECT_EQ(rows_of(table), whole);
  EXPECT_EQ(text_of(folder_ / "all rows.jsonl"), rows) << "every row was there";
}

TEST_F(OnSlurm, ABatchInTasksAndTheRecipeOfRobustnessAreThoseOfOneProgram) {
  const std::string floor = write("still.yaml", "still: {duration_s: 0.2}\n").string(),
                    block = config("controllers/force_feedback_5hz.yaml").string(),
                    uncertainty = config("uncertainty/piezo_frame.yaml").string();
  const std::vector<std::string> call{
      "batch",      frame_, "--controller", block,
      "--floor",    floor,  "--floor",      config("floors/multisine.yaml").string(),
      "--duration", "0.2"};
  const Json whole = rows_of(call);
  const std::string robustness = "$BIN/stillframe robustness " + frame_ + " --uncertainty " +
                                 uncertainty + " --samples 30 --no-search ";
  std::string batch = "$BIN/stillframe";
  for (const std::string& word : call) batch += " '" + word + "'";
  on_slurm(batch +
           " --out rows.jsonl --on slurm:8\n"
           // As its help has it.
           "sbatch --array=1-3 --output=shard_%a.log --wrap '" +
           robustness +
           "--shard ${SLURM_ARRAY_TASK_ID}/3 --out part_${SLURM_ARRAY_TASK_ID}.json'\n"
           "wait_for_all\n"
           "$BIN/stillframe merge part_*.json --out all.json\n" +
           robustness +
           "--out one.json\n"
           "cmp all.json one.json\n");
  if (IsSkipped() || HasFatalFailure()) return;
  const std::string rows = text_of(folder_ / "rows.jsonl");
  auto table = call;
  table.insert(table.end(), {"--out", (folder_ / "rows.jsonl").string()});
  EXPECT_EQ(rows_of(table), whole);
  EXPECT_EQ(text_of(folder_ / "rows.jsonl"), rows) << "every run was there";
}

TEST_F(OnSlurm, WhatCannotBeSubmittedIsOneMessage) {
  const std::vector<std::string> call{"sweep", frame_, "--set", "controller.target_hz=3,4"};
  const auto refused = [&](std::vector<std::string> more, const std::string& message) {
    more.insert(more.begin(), call.begin(), call.end());
    expect_refused(more, 2, message);
  };
  const std::string out = (folder_ / "rows.jsonl").string();
  refused({"--on", "slurm:3"}, "--out is missing");
  refused({"--on", "slurm:0", "--out", out}, "--on: found 'slurm:0', allowed is slurm:N");
  refused({"--on", "pbs:3", "--out", out}, "--on: found 'pbs:3'");
  refused({"--on", "slurm:3", "--out", out, "--shard", "1/2"}, "a --shard of its own");
  // A host without Slurm, whatever is installed here.
  const Said said = shell("PATH=/nowhere $BIN/stillframe sweep " + frame_ +
                          " --set controller.target_hz=3,4 --out " + out + " --on slurm:3");
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(said.error.find("is this a host from which Slurm takes jobs?"), std::string::npos)
      << said.error;
}

/// An sbatch of our own runs each task at once, and so shows what becomes of rows that were known.
TEST_F(OnSlurm, WhatTasksComputeCountsAgainstWhatWasKnown) {
  const std::string out = (folder_ / "rows.jsonl").string(),
                    fake = "PATH='" + folder_.string() + "':$PATH ",
                    call = STILLFRAME_BIN_DIR "/stillframe sweep " + frame_ +
                           " --set controller.target_hz=3,4,5,6 --out " + out;
  const auto sbatch = [&](const std::string& text) {
    const auto file = write("sbatch", "#!/bin/sh\n" + text);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  };
  ASSERT_EQ(shell(call + " --at 10").exit_code, 0);
  sbatch(
      "for script; do :; done\ncase \"$*\" in *--array=1-3*)\n"
      "  for i in 1 2 3; do SLURM_ARRAY_TASK_ID=$i sh \"$script\"; done;;\n"
      "*) sh \"$script\";; esac\necho 17\n");
  const Said said = shell(fake + call + " --at 50 --on slurm:3");
  ASSERT_EQ(said.exit_code, 0) << said.error;
  std::ifstream rows(out);
  int n_rows = 0;
  for (std::string row; std::getline(rows, row); ++n_rows) {
    EXPECT_NE(row.find("\"transmission\":[{\"hz\":50"), std::string::npos) << row;
  }
  EXPECT_EQ(n_rows, 4);
  // What is no number of a job goes into no shell, and tasks that have been taken are named.
  sbatch("echo '12 $(touch " + (folder_ / "ran").string() + ")'\n");
  const Said rubbish = shell(fake + call + " --at 60 --on slurm:2");
  EXPECT_EQ(rubbish.exit_code, 4);
  EXPECT_NE(rubbish.error.find("instead of the number of a job"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "ran"));
  sbatch("case \"$*\" in *--array*) echo 4242;; *) exit 1;; esac\n");
  const Said orphaned = shell(fake + call + " --at 60 --on slurm:2");
  EXPECT_EQ(orphaned.exit_code, 4);
  EXPECT_NE(orphaned.error.find("`scancel 4242`"), std::string::npos) << orphaned.error;
}

/// The recipe of the help, with GNU parallel.
TEST_F(OnSlurm, ShardsOfGnuParallelMergeToTheWhole) {
  if (std::system("command -v parallel > /dev/null") != 0) GTEST_SKIP() << "needs parallel";
  const std::vector<std::string> call{"sweep", frame_, "--set", "controller.target_hz=3:6:7"};
  const Json whole = rows_of(call);
  const std::string sweep = "$BIN/stillframe sweep " + frame_ + " --set controller.target_hz=3:6:7";
  const Said said = shell("set -e; cd " + folder_.string() + "\nseq 4 | parallel " + sweep +
                          " --shard {}/4 --out part_{}.jsonl > /dev/null\n"
                          "$BIN/stillframe merge part_*.jsonl --out all.jsonl\n" +
                          sweep + " --out all.jsonl --json > all.json\n");
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_EQ(said.output, "7 rows of `sweep` in all.jsonl\n");
  EXPECT_EQ(Json::parse(text_of(folder_ / "all.json")), whole);
}

}  // namespace
}  // namespace stillframe::test
