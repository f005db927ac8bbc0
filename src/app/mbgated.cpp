// SPDX-License-Identifier: Apache-2.0
#include "app/mbgated.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sysexits.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "app/command_line.hpp"
#include "app/configuration/digest.hpp"
#include "app/log.hpp"
#include "app/recording.hpp"
#include "app/service.hpp"
#include "config/load.hpp"
#include "config/text_file.hpp"
#include "io/clients/resources.hpp"

namespace mbgate::app {
namespace {

/// The last lines have this long to be written; a standard error that nobody reads must not keep
/// the process.
constexpr std::chrono::milliseconds kLogFlush{150};

/// The same for the recording.
constexpr std::chrono::milliseconds kRecordingFlush{100};

/// The file that a recording goes to, and its head.
struct RecordingBegun {
  sys::UniqueFd file;
  std::string head;
};

/// Locks only what is ever touched: a thread's stack is much larger than what it uses. But against
/// a limit all of it counts, and later threads and lines would be refused: so not with a limit.
void lock_memory(Log& log) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY) {
    log.write(Level::warning,
              "lock_memory: the memory is not locked: expected an unlimited limit of locked memory "
              "(drop-in realtime.conf of the service, or \"ulimit -l unlimited\")",
              {.id = message_id::kMemoryNotLocked});
  } else if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    log.write(Level::warning,
              "lock_memory: not possible: " + std::generic_category().message(errno),
              {.id = message_id::kMemoryNotLocked});
  }
}

/// The settings out of one reading of the files, so that what is recorded is what is run.
Configuration load(const Options& options) {
  const auto files = options.text
                         ? std::vector{config::TextFile{options.config.string(), *options.text}}
                         : config::read_config_files(options.config);
  Configuration configuration;
  configuration.loaded = config::load_settings(files, {.folder = options.profiles});
  auto digested = files;
  std::ranges::copy(configuration.loaded.profiles, std::back_inserter(digested));
  configuration.digest = config_digest(digested);
  configuration.digested =
      options.text ? "these options, --print-config | sha256sum" : digest_command(digested);
  if (configuration.loaded.settings && !options.print) {
    configuration.tls =
        io::load_tls(*configuration.loaded.settings,
                     options.check ? io::KeyCheck::leave_out : io::KeyCheck::ask_signer);
  }
  if (options.record) {
    configuration.files = recorded_files(files);
  }
  return configuration;
}

/// The path of the file, or the option that stands in for one.
std::string config_name(const Options& options) {
  return options.text ? options.config.string()
                      : std::filesystem::absolute(options.config).string();
}

int serve(Configuration first, const Options& options, const std::string& version,
          std::optional<RecordingBegun> recording) {
  Log log(is_standard_error_the_journal());
  if (first.loaded.settings->lock_memory) {
    lock_memory(log);
  }
  int status = EXIT_FAILURE;
  try {
    std::optional<io::Recorder> recorder;
    if (recording) {
      recorder.emplace(std::move(recording->file), recording->head, [&](const std::string& why) {
        log.write(Level::warning, "the recording has ended: " + why,
                  {.id = message_id::kRecordingEnded});
      });
    }
    const auto read = [options] {
      Configuration configuration;
      try {
        configuration = load(options);
      } catch (const std::exception& exception) {
        configuration.failure = std::string("cannot read the configuration: ") + exception.what();
      }
      return configuration;
    };
    const About about{version, config_name(options)};
    Service service(std::move(first), about, read, log, recorder ? &*recorder : nullptr);
    status = service.run();
    if (recorder && !recorder->close(kRecordingFlush)) {
      log.write(Level::warning, "the recording is not complete",
                {.id = message_id::kRecordingEnded});
    }
  } catch (const std::exception& exception) {
    log.write(Level::error, std::string("fatal: ") + exception.what(), {.id = message_id::kFatal});
  }
  if (!log.flush(kLogFlush)) {
    std::_Exit(status);
  }
  return status;
}

/// What is wrong was written to standard error line by line. An entry of its own can be searched
/// for, and says what to do.
void tell_journal_of_wrong_configuration() {
  Log log(true);
  log.write(Level::error, "the configuration is wrong: mbgated does not start",
            {.id = message_id::kStartRefused});
  if (!log.flush(kLogFlush)) {
    std::_Exit(EX_CONFIG);
  }
}

Result<RecordingBegun, std::string> begin_recording(const Options& options,
                                                    std::vector<report::ConfigFile> config,
                                                    const std::string& version) {
  auto file = create_recording(recording_path(*options.record, std::getenv("STATE_DIRECTORY")));
  if (!file) {
    return file.error();
  }
  report::RecordingHead head;
  head.version = version;
  head.profiles = options.profiles ? std::filesystem::absolute(*options.profiles).string() : "";
  head.config = std::move(config);
  return RecordingBegun{*std::move(file), report::head_lines(head)};
}

/// What --check says of a configuration without errors. The exit status.
int print_check(const Configuration& checked, const std::string& file) {
  const auto say = [&file](config::Severity severity, const std::string& text) {
    std::cerr << config::render({severity, file, {}, text, {}});
  };
  const gateway::Settings& settings = *checked.loaded.settings;
  const auto room = io::room_for_clients(settings, io::hard_descriptor_limit());
  if (room.shortage) {
    say(config::Severity::warning, *room.shortage);
  }
  for (const std::string& warning : checked.tls.warnings) {
    say(config::Severity::warning, warning);
  }
  for (const std::string& failure : checked.tls.failures) {
    say(config::Severity::error, failure);
  }
  if (!checked.tls.failures.empty()) {
    return EX_CONFIG;
  }
  std::cout << config::check_summary(settings) << "\nsha256 " << checked.digest << ": "
            << checked.digested << '\n';
  return EXIT_SUCCESS;
}

/// Exits 1 if it is permitted nowhere.
int say_who(const config::Loaded& loaded, const WhoOptions& who) {
  const auto answers = answer_who(*loaded.settings, loaded.places, who);
  if (!answers) {
    std::cerr << "mbgated: " << answers.error() << '\n';
    return EX_USAGE;
  }
  std::cout << answers->text;
  return answers->any_permitted ? EXIT_SUCCESS : EXIT_FAILURE;
}

void change_mask(int how) {
  sigset_t held;
  sigemptyset(&held);
  sigaddset(&held, SIGHUP);
  ::pthread_sigmask(how, &held, nullptr);
}

}  // namespace

int run_mbgated(int argc, const char* const* argv, const std::string& version) {
  hold_signals();
  const auto parsed = parse_command_line(argc, argv, version);
  if (const int* const status = std::get_if<int>(&parsed)) {
    return *status;
  }
  const auto& options = std::get<Options>(parsed);
  Configuration configuration = load(options);
  config::Loaded& loaded = configuration.loaded;
  std::cerr << config::render(loaded.diagnostics) << std::flush;
  if (!loaded.settings) {
    if (!options.check && !options.print && is_standard_error_the_journal()) {
      tell_journal_of_wrong_configuration();
    }
    return options.text ? EX_USAGE : EX_CONFIG;
  }
  if (options.print) {
    std::cout << options.text.value_or("");
    return EXIT_SUCCESS;
  }
  if (options.who) {
    return say_who(loaded, *options.who);
  }
  if (options.check) {
    return print_check(configuration, options.config.string());
  }
  std::optional<RecordingBegun> recording;
  if (options.record) {
    auto begun = begin_recording(options, std::move(configuration.files), version);
    if (!begun) {
      std::cerr << "mbgated: " << begun.error() << '\n';
      return EX_CANTCREAT;
    }
    recording = *std::move(begun);
  }
  return serve(std::move(configuration), options, version, std::move(recording));
}

void hold_signals() {
  for (const int ignored : {SIGPIPE, SIGUSR1, SIGUSR2, SIGXFSZ}) {
    std::signal(ignored, SIG_IGN);
  }
  change_mask(SIG_BLOCK);
}

void release_held_signals() { change_mask(SIG_UNBLOCK); }

}  // namespace mbgate::app
