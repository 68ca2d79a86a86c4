// SPDX-License-Identifier: AGPL-3.0-or-later
// What runs write, and where.

#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/error.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
namespace fs = std::filesystem;

namespace {

const std::vector<std::string> box = {"20", "20", "20", "--rbc", "3"};

/// The request of these words about a box.
Request stated(const std::vector<std::string>& words) {
  std::vector<std::string> all = box;
  all.insert(all.end(), words.begin(), words.end());
  return parseCommandLine("packMesh", all).request;
}

OutputRequest outputs(const std::vector<std::string>& words) {
  return outputsToPack(requestToPack(stated(words)));
}

}  // namespace

TEST_CASE("Checkpoints are named after the state of the result") {
  for (const char* state : {"state.h5", "a b/c.d.h5", "/folder.checkpoint/s", "s"}) {
    CAPTURE(state);
    CHECK_FALSE(isCheckpoint(state));
    CHECK(resultOf(state) == state);
    CHECK(isCheckpoint(checkpointOf(state)));
    CHECK(resultOf(checkpointOf(state)) == state);
  }
  CHECK(checkpointOf("run/state.h5") == "run/state.checkpoint.h5");
}

TEST_CASE("Deformed cells alone, whose state is always written, are no request for checkpoints") {
  const Request request;
  OutputRequest output;
  CHECK_FALSE(savesCheckpoints(request, output));
  output.stateFile = "state.h5";
  CHECK_FALSE(savesCheckpoints(request, output));
  Request named, continued;
  named.origins["stateFile"] = {};
  continued.restart = "state.checkpoint.h5";
  for (const Request& one : {named, continued}) CHECK(savesCheckpoints(one, output));
  output.checkpointEvery = 1.0;
  CHECK(savesCheckpoints(request, output));
}

TEST_CASE("Outputs are in the folder of the case or where a run continues, and the request stays as stated") {
  const CompletedRequest completed = requestToPack(stated({"--checkpoint-every", "60"}));
  const OutputRequest output = outputsToPack(completed);
  CHECK(output.folder == ".");
  CHECK(output.stateFile == fs::path("./state.h5"));
  CHECK(completed.request.output.folder.empty());
  CHECK_FALSE(completed.request.output.stateFile);
  CHECK_FALSE(outputs({}).stateFile);
  CHECK(outputs({"--output-dir", "out", "--checkpoint-every", "60"}).stateFile == fs::path("out/state.h5"));
  CHECK(outputs({"--restart", "old/s.checkpoint.h5"}).stateFile == fs::path("old/s.h5"));
  CompletedRequest deformed = completed;
  deformed.deformed = true;
  deformed.request.output.checkpointEvery = 0.0;
  CHECK(outputsToPack(deformed).stateFile == fs::path("./state.h5"));
}

TEST_CASE("A series of realisations continues in the folder that contains all of them") {
  const std::vector<std::string> series = {"--realisations", "3", "--restart"};
  const auto from = [&](const std::string& state) {
    std::vector<std::string> words = series;
    words.push_back(state);
    return outputs(words);
  };
  const OutputRequest output = from("all/realisation_2/state.h5");
  CHECK(output.realisation == 2);
  CHECK(fs::path(output.folder).filename() == "all");
  CHECK_THROWS_WITH(from("state.h5"), Contains("realisations continue from the state of one of them"));
}

TEST_CASE("Outputs that cannot be are refused") {
  CHECK_THROWS_WITH(outputs({"--report", "r.txt"}), Contains("ends in .json or .html"));
  CHECK_THROWS_WITH(outputs({"--clearance", "max", "--state", "s.h5"}), Contains("a state belongs to one"));
}

TEST_CASE("Front ends that write no files leave out what only the program writes") {
  const CompletedRequest plain = requestToPack(stated({"--export", "csv", "--report", "r.json"}));
  const OutputRequest running = outputsInRunning(plain);
  CHECK(running.exports.empty());
  CHECK(running.reportFile == fs::path("r.json"));
  const Request inFolder = stated({"--export", "csv", "--output-dir", "out"});
  CHECK(outputsInRunning(requestToPack(inFolder)).exports == std::vector<std::string>{"csv"});
  const OutputRequest memory = outputsInMemory(inFolder, requestToPack(inFolder));
  CHECK(memory.folder == "out");
  CHECK_FALSE(memory.asksForViews());
  CHECK_FALSE(memory.stateFile);
  const Request withState = stated({"--state", "s.h5"});
  CHECK(outputsInMemory(withState, requestToPack(withState)).stateFile == fs::path("s.h5"));
}

TEST_CASE("A check writes what its own front end requests") {
  Request asked;
  asked.boxSize = Vec3(20, 20, 20);
  asked.output.vtp = true;
  CompletedRequest completed = requestToCheck(asked);
  completed.request.output.exports = {"csv"};  // as a configuration may
  completed.request.output.folder = "cells";
  const OutputRequest output = outputsToCheck(asked, completed);
  CHECK(output.vtp);
  CHECK(output.exports.empty());
  CHECK(output.folder == "cells");
  CHECK(outputsToCheck(asked, completed, fs::path("other")).folder == "other");
}

TEST_CASE("States of the engine are written if an interval is stated") {
  OutputRequest output;
  output.folder = "out";
  CHECK_FALSE(requestedFrames(output));
  output.frames = 4;
  CHECK(requestedFrames(output)->every == 4);
  CHECK(requestedFrames(output)->folder == "out");
}
