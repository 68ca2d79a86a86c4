// SPDX-License-Identifier: AGPL-3.0-or-later
#include "caller.h"

#include <filesystem>
#include <string>
#include <utility>

#include "hemocell_adapter/base/agreed_failure.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "packMesh/core/error.h"

namespace py = pybind11;
using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

using namespace std::chrono_literals;

/// Between two looks for signals, and between two reports of progress.
constexpr auto pollInterval = 20ms, progressInterval = 100ms;

/// What Python raised while the library ran: of a signal, a callback, a handler of the log.
std::exception_ptr raised;

/// Calls Python from a library that runs without its lock.
template <class Call>
void inPython(Call&& call) {
  const py::gil_scoped_acquire locked;
  try {
    call();
  } catch (const py::error_already_set&) {
    if (!raised) raised = std::current_exception();
  }
}

int loggingLevel(log::Kind kind) {
  constexpr int levels[] = {10, 20, 30, 40};  // DEBUG, INFO, WARNING, ERROR
  return levels[int(kind)];
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

void raise(const Failure& failure) {
  if (failure.code == ExitCode::interrupted)
    return PyErr_SetString(PyExc_KeyboardInterrupt, failure.message.c_str());
  const py::object type = py::module_::import("packmesh.errors").attr(classOf(failure.code));
  // Messages quote names of files, which need not be UTF-8.
  const py::object text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(failure.message.data(), py::ssize_t(failure.message.size()), "replace"));
  PyErr_SetObject(type.ptr(), text.ptr());
}

}  // namespace

void logToPython() {
  const py::module_ logging = py::module_::import("logging");
  const py::object logger = logging.attr("getLogger")("packmesh");
  logger.attr("addHandler")(logging.attr("NullHandler")());
  auto held = std::make_shared<py::object>(logger.attr("log"));
  log::setSink([held](log::Kind kind, const std::string& message) {
    inPython([&] {
      (*held)(loggingLevel(kind), py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
                                      message.data(), py::ssize_t(message.size()), "replace")));
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

RunHooks Caller::hooks() {
  RunHooks hooks;
  hooks.interrupted = [this] { return interrupted(); };
  hooks.progress = [this](const Progress& progress) { tell(progress); };
  return hooks;
}

std::recursive_mutex& Caller::mutex() {
  static std::recursive_mutex one;
  return one;
}

void Caller::begin() {
  raised = nullptr;
  log::setLevel(log::Level::verbose);
}

void Caller::rethrowRaised() {
  if (raised) std::rethrow_exception(std::exchange(raised, nullptr));
}

bool Caller::interrupted() {
  if (raised) return true;
  const auto now = Clock::now();
  if (now - polled_ < pollInterval) return false;
  polled_ = now;
  inPython([] {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  });
  return raised != nullptr;
}

void Caller::tell(const Progress& progress) {
  if (progress_.is_none() || raised) return;
  const auto now = Clock::now();
  if (told_ && now - *told_ < progressInterval) return;
  told_ = now;
  inPython([&] {
    progress_(progress.stage, progress.sweep, progress.scale, progress.worstOverlap, progress.unresolved);
  });
}
