// SPDX-License-Identifier: AGPL-3.0-or-later
#include "caller.h"

#include <fmt/format.h>
#include <pthread.h>
#include <pybind11/stl.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "packMesh/core/error.h"

namespace py = pybind11;
using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

using namespace std::chrono_literals;

/// Between two looks for signals, and between two reports of progress.
constexpr auto pollInterval = 20ms, progressInterval = 100ms;

/// What Python raised while the library ran.
struct Raised {
  std::exception_ptr error;
  const char* by = "";  ///< which call of Python
};
Raised raised;

/// Calls Python from a library that runs without its lock.
/// @param what is called
template <class Call>
void inPython(const char* what, Call&& call) {
  const py::gil_scoped_acquire locked;
  try {
    call();
  } catch (const py::error_already_set&) {
    if (!raised.error) raised = {std::current_exception(), what};
  }
}

/// Whose turn it is. Never deleted: threads can outlive objects with static storage.
std::recursive_timed_mutex* turns = new std::recursive_timed_mutex;

/// In a forked process: the thread whose turn it was is not there.
void forgetTurns() {
  turns = new std::recursive_timed_mutex;
  new (&raised) Raised;  // what was raised belongs to the other process
}

[[maybe_unused]] const int registered = pthread_atfork(nullptr, nullptr, &forgetTurns);

void checkSignals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// "KeyError: 'text'"
std::string exceptionText(const py::error_already_set& error) {
  const std::string type = py::str(error.type().attr("__name__"));
  try {
    const std::string text = py::str(error.value());
    return text.empty() ? type : type + ": " + text;
  } catch (const py::error_already_set&) {  // its __str__ raises
    return type;
  }
}

/// DEBUG, INFO, WARNING, ERROR
int loggingLevel(log::Kind kind) {
  return 10 * (int(kind == log::Kind::repair ? log::Kind::warning : kind) + 1);
}

const char* classOf(ExitCode code) {
  switch (code) {
    case ExitCode::usage:
    case ExitCode::badInput:
    case ExitCode::notConnected:  // the communicator is not what its caller believes
      return "InputError";
    case ExitCode::outOfReach:
      return "InfeasibleError";
    case ExitCode::cannotWrite:
      return "OutputError";
    default:
      return "InternalError";
  }
}

/// A message with the names of Python's arguments. It may quote names of files, which need not be UTF-8.
py::object inPythonsWords(const std::string& marked) {
  const std::string message = inTermsOfUser(marked);
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(message.data(), py::ssize_t(message.size()), "replace"));
}

/// @param name of a class of packmesh.errors
void raise(const char* name, const std::string& message) {
  const py::object type = py::module_::import("packmesh.errors").attr(name);
  PyErr_SetObject(type.ptr(), inPythonsWords(message).ptr());
}

void raise(const Failure& failure) {
  if (failure.code == ExitCode::interrupted)
    return PyErr_SetString(PyExc_KeyboardInterrupt, failure.message.c_str());
  raise(classOf(failure.code), failure.message);
}

}  // namespace

void logToPython() {
  const py::module_ logging = py::module_::import("logging");
  const py::object logger = logging.attr("getLogger")("packmesh");
  auto held = std::make_shared<py::object>(logger.attr("log"));
  log::setSink([held](log::Kind kind, const std::string& message) {
    inPython("a handler of the log", [&] {
      const py::object text = inPythonsWords(message);
      if (kind == log::Kind::repair)
        py::module_::import("packmesh.errors").attr("warn_of_repair")(text);
      else
        (*held)(loggingLevel(kind), text);
    });
  });
  // At exit, Python ends before the objects of the library.
  py::module_::import("atexit").attr("register")(py::cpp_function([held] {
    log::setSink([](log::Kind, const std::string&) {});
    *held = py::none();
  }));
}

void registerErrors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const AgreedFailure&) {
      raise(failureOfException());
    } catch (const Error&) {
      raise(failureOfException());
    } catch (const std::filesystem::filesystem_error&) {
      raise(failureOfException());
    }
  });
}

void Caller::listenTo(const Communicator& ranks) {
  log::setLevel(ranks.rank() > 0 ? log::Level::silent : log::Level::verbose);
}

Hooks Caller::hooks() {
  Hooks hooks;
  hooks.interrupted = [this] { return interrupted(); };
  hooks.progress = [this](const Progress& progress, ProgressLog& log) { tell(progress, log); };
  hooks.convertsFrames = false;
  return hooks;
}

Caller::Turn::Turn() : turns_(turns) {
  while (!turns_->try_lock_for(pollInterval)) {
    const py::gil_scoped_acquire locked;
    checkSignals();
  }
}

Caller::Turn::~Turn() {
  turns_->unlock();
}

void Caller::begin() {
  raised = {};
  log::setLevel(log::Level::verbose);
}

void Caller::rethrowRaised() {
  if (raised.error) std::rethrow_exception(std::exchange(raised, {}).error);
}

void Caller::tellOtherRanks(const Communicator& ranks, bool failed) {
  if (ranks.alone() || !ranks.any(raised.error != nullptr)) return;
  const auto first = ranks.min(std::int64_t(raised.error ? ranks.rank() : ranks.size()));
  bool isSignal = false;
  std::string text;
  if (first == ranks.rank()) {
    const py::gil_scoped_acquire locked;
    try {
      std::rethrow_exception(raised.error);
    } catch (const py::error_already_set& error) {
      isSignal = error.matches(PyExc_KeyboardInterrupt);
      text = fmt::format("{} on rank {} raised {}", raised.by, first, exceptionText(error));
    }
  }
  isSignal = ranks.any(isSignal);
  text = ranks.broadcast(text, int(first));
  if (raised.error || (isSignal && failed)) return;
  inPython("", [&] {
    if (isSignal)
      raise({ExitCode::interrupted, fmt::format("interrupted on rank {}", first)});
    else
      raise("RankError", text);
    throw py::error_already_set();
  });
}

bool Caller::interrupted() {
  if (raised.error) return true;
  const auto now = Clock::now();
  if (now - polled_ < pollInterval) return false;
  polled_ = now;
  inPython("a handler of a signal", checkSignals);
  return raised.error != nullptr;
}

void Caller::tell(const Progress& progress, ProgressLog& log) {
  if (progress_.is_none() || raised.error) return;
  const auto now = Clock::now();
  if (told_ && now - *told_ < progressInterval) return;
  told_ = now;
  const double seconds = log.seconds();
  const std::optional<double> remaining = log.remaining(seconds);
  const std::string text = log.text(progress, seconds);
  inPython("the callback `progress`", [&] {
    progress_(progress.stage, progress.sweep, progress.scale, progress.worstOverlap, progress.unresolved,
              seconds, remaining, text);
  });
}
