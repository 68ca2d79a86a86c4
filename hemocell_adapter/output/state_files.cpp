// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/state_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/settings/request_json.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// The folder of a state with "/" at its end.
std::string folderNameOf(const fs::path& state) {
  return (fs::absolute(state).lexically_normal().parent_path() / "").string();
}

bool isUtf8(const Json& text) {
  try {
    static_cast<void>(text.dump());
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

/// Replaces texts in JSON.
template <class Replace>
Json mapped(const Json& json, const Replace& replace) {
  if (auto replaced = replace(json)) return *replaced;
  if (!json.is_structured()) return json;
  Json all = json.is_array() ? Json::array() : Json::object();
  for (const auto& [key, value] : json.items()) {
    if (json.is_array())
      all.push_back(mapped(value, replace));
    else
      all[key] = mapped(value, replace);
  }
  return all;
}

std::optional<Json> stored(const Json& json, const std::string& folder) {
  if (!json.is_string()) return {};
  const std::string text = json.get<std::string>();
  if (text.size() > folder.size() && text.compare(0, folder.size(), folder) == 0)
    return Json{
        {"beside", stored(Json(text.substr(folder.size())), folder).value_or(text.substr(folder.size()))}};
  if (isUtf8(json)) return {};
  return Json{{"bytes", std::vector<unsigned char>(text.begin(), text.end())}};
}

std::optional<Json> now(const Json& json, const std::string& folder) {
  if (!json.is_object() || json.size() != 1) return {};
  if (const auto bytes = json.find("bytes"); bytes != json.end() && bytes->is_array()) {
    std::string text;
    for (const Json& byte : *bytes)
      if (byte.is_number_unsigned()) text += static_cast<char>(byte.get<unsigned>());
    return Json(text);
  }
  const auto beside = json.find("beside");
  if (beside == json.end()) return {};
  const Json path = now(*beside, folder).value_or(*beside);
  if (!path.is_string()) return {};
  return Json(fs::path(folder + path.get<std::string>()).lexically_normal().string());
}

/// The numbers of a record. Those of a table are "<key>\n<name>".
MemoryInputs memoryInputsIn(const StateRecord& record) {
  std::map<std::string, MemoryInput> all;
  for (const StateTable& input : record.inputs) {
    const std::size_t end = input.name.find('\n');
    if (end == std::string::npos) continue;
    MemoryInput& given = all[input.name.substr(0, end)];
    given.tables.push_back({input.name.substr(end + 1), input.columns, input.values});
  }
  MemoryInputs gifts;
  for (auto& [key, given] : all) {
    given.key = "of the state: " + key;  // unlike those of a request that overrides that of the state
    given.what = key;
    gifts[key] = std::make_shared<const MemoryInput>(std::move(given));
  }
  return gifts;
}

}  // namespace

StateRecord recordOf(const Request& request, const fs::path& state) {
  StateRecord record;
  const std::string folder = folderNameOf(state);
  Json json = toJson(withFiles(request, [&](const fs::path& file) {
    if (file.is_absolute()) return file;
    const fs::path whole = (request.workingFolder / file).lexically_normal();
    return fs::path(folder + whole.lexically_relative(fs::path(folder).parent_path()).string());
  }));
  json.erase("restart");
  record.request = mapped(json, [&](const Json& one) { return stored(one, folder); }).dump();
  for (const auto& [key, given] : memoryInputsOf(request))
    for (const StateTable& table : given->tables)
      record.inputs.push_back({key + "\n" + table.name, table.columns, table.values});
  return record;
}

Request requestIn(const StateRecord& record, const fs::path& state) {
  if (!record.origin.empty())
    throw InputError(
        fmt::format("{}: has the cells of a simulation, and no packing to continue: {}, {} and {} take them",
                    state.string(), named("start"), named("fixed"), named("blood")));
  if (record.request.empty())
    throw InputError(
        state.string() +
        ": is of an earlier version of packMesh, which reads what was asked for; this version reads "
        "its cells and templates");
  const Json json = Json::parse(record.request, nullptr, false);
  if (json.is_discarded()) throw InputError(state.string() + ": is damaged: its request is not JSON");
  const std::string folder = folderNameOf(state);
  return located(state.string(), [&] {
    return withJson({}, mapped(json, [&](const Json& one) { return now(one, folder); }),
                    {Origin::Kind::state, ""}, memoryInputsIn(record));
  });
}

namespace {

/// What it took to get there.
std::string effortOf(const PackingState& state) {
  return state.engine ? fmt::format("{} {}", state.engine->iterations(), state.engine->unit())
                      : fmt::format("{} sweeps", state.relaxation.sweeps);
}

/// @throws InputError if there is no such file, but a checkpoint of the run that was to write it
void requireNoOtherName(const std::optional<fs::path>& restart) {
  if (restart && !isThere(*restart) && isThere(checkpointOf(*restart)))
    throw InputError(fmt::format("{}: no such file; the run has not ended, and is continued from {}",
                                 restart->string(), checkpointOf(*restart).string()));
}

/// @throws OutputError if a file is there that is no state of packMesh and not that from which the run
/// continues
void requireReplaceableState(const Request& request, const fs::path& file) {
  try {
    requireReplaceable(file);
    std::error_code ignored;
    const bool continued = request.restart && fs::equivalent(file, *request.restart, ignored);
    if (!continued && isThere(file)) readStateHead(file, oldestStateVersion);
  } catch (const Error& error) {
    throw OutputError(fmt::format("{}; the state is not written over it ({} names another file)",
                                  error.what(), named("state")));
  }
}

}  // namespace

Request continued(const Request& asked) {
  requireNoOtherName(asked.restart);
  if (!asked.restart || asked.hasLumen()) return asked;
  const fs::path& state = *asked.restart;
  Request all = overridden(requestIn(readStateHead(state).record, state), asked);
  all.words.clear();  // those of the restart alone
  return all;
}

void requireReplaceableState(const Request& request, const OutputRequest& output) {
  if (!output.stateFile) return;
  const fs::path& file = *output.stateFile;
  requireWritable(file.parent_path());
  for (const char* kind : {".pos", ".pov"})
    if (file.extension() == kind)
      throw OutputError(
          fmt::format("{}: {} files are used for cells; the state needs another name", file.string(), kind));
  if (isCheckpoint(file))
    throw OutputError(
        fmt::format("{}: is the name of a checkpoint; the state of the result needs another one, such as {}",
                    file.string(), resultOf(file).string()));
  requireReplaceableState(request, file);
  if (savesCheckpoints(request, output)) requireReplaceableState(request, checkpointOf(file));
}

std::optional<Checkpoints> StateFiles::checkpoints() {
  if (!output_.stateFile) return {};
  Checkpoints checkpoints;
  if (isContinued_ && savesCheckpoints(request_, output_))
    checkpoints.due = [this] {
      const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_;
      return checkpointAsked() || (output_.checkpointEvery > 0.0 && since.count() >= output_.checkpointEvery);
    };
  checkpoints.save = [this](const PackingState& state) { save(state); };
  checkpoints.endsWithFewer = request_.bestEffort;
  checkpoints.savesFailed = savesFailed_;
  return checkpoints;
}

void StateFiles::save(const PackingState& state) {
  if (isFinished(state, problem_.execution.communicator)) {
    end_ = state;
    return;
  }
  if (!isContinued_ || !savesCheckpoints(request_, output_)) return;
  const fs::path file = checkpointFile(output_);
  saved_ = false;
  try {
    writeState(file, problem_, recordOf(*request_.asked, file), state);
    saved_ = savedAny_ = true;
  } catch (const OutputError& error) {
    log::warning(error.what());
  }
  if (*saved_) log::detail(fmt::format("Saved the state after {} in {}", effortOf(state), file.string()));
  last_ = std::chrono::steady_clock::now();
  forgetCheckpointAsked();
}

std::unique_ptr<AtomicFiles> preparedResult(const Packing& packing, const fs::path& file,
                                            const FilesOfState& together) {
  const Problem& problem = *packing.problem;
  const auto prepare = [&](const PackingState& state) {
    return preparedState(file, packingProblemOf(problem, packing.packed),
                         recordOf(*problem.request.asked, file), state, together);
  };
  PackingState state = *packing.state;
  if (problem.hasDeformed()) state.columns = deformationColumns(problem, packing.packed, state.cells);
  state.columns.push_back(angleColumn(state.cells, *problem.read));
  return prepare(state);
}

namespace {

bool saveAlone(const Packing& packing, const fs::path& file) {
  try {
    const std::unique_ptr<AtomicFiles> files = preparedResult(packing, file, {});
    writeTogether(packing.problem->ranks, [&] { files->commit(); });
    return true;
  } catch (const OutputError& error) {
    log::warning(error.what());
    return false;
  }
}

}  // namespace

bool saveResult(const Packing& packing) {
  return saveAlone(packing, *packing.output.stateFile);
}

bool saveAsCheckpoint(const Packing& packing) {
  return saveAlone(packing, checkpointFile(packing.output));
}

void makeStateFolder(const OutputRequest& output, const Communicator& ranks) {
  if (output.stateFile) SharedFiles(ranks).makeFolder(output.stateFile->parent_path());
}

fs::path checkpointFile(const OutputRequest& output) {
  return checkpointOf(*output.stateFile);
}

void removeCheckpoint(const Request& request, const OutputRequest& output, bool own) {
  const fs::path file = checkpointFile(output);
  if (!isThere(file)) return;
  std::error_code ignored;
  if (own || (request.restart && fs::equivalent(file, *request.restart, ignored)))
    fs::remove(file, ignored);
  else
    log::info(fmt::format("{} is the checkpoint of another run, and stays", file.string()));
}

PackingState stateToContinue(const std::filesystem::path& file, const PackingProblem& problem) {
  PackingState state = readState(file, problem);
  log::info(fmt::format("Continuing from {}: after {}", file.string(), effortOf(state)));
  return state;
}

}  // namespace packmesh::hemocell
