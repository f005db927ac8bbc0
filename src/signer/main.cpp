// SPDX-License-Identifier: Apache-2.0
// mbgate-signer: holds the private keys of mbgated, which cannot read them, and signs with them.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sysexits.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "signer/door.hpp"
#include "sys/unique_fd.hpp"

namespace {

constexpr const char* kUsage =
    "usage: mbgate-signer [--keys DIR] [--key NAME]... [--certificates DIR] [--socket PATH]\n"
    "Signs for mbgated with the private keys in DIR (default: /etc/mbgate/tls) whose files\n"
    "have one of these names or patterns (default: *.key), but with no key of an authority\n"
    "whose certificate is there or among the certificates (default: /etc/mbgate/certs).\n"
    "Listens at the socket that systemd hands over, or at PATH.\n";
/// Of systemd (sd_listen_fds(3)).
constexpr int kFirstHandedOver = 3;
constexpr int kBacklog = 16;

volatile std::sig_atomic_t ended = 0;

void end(int /*signal*/) { ended = 1; }

struct Options {
  mbgate::signer::KeyStore keys{"/etc/mbgate/tls", {}, "/etc/mbgate/certs"};
  std::string socket{};
};

/// Nothing: the command line is wrong, or asked for no more than help; `status` says which.
std::optional<Options> options_of(int argc, char** argv, int& status) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const bool has_value = i + 1 < argc;
    if (word == "--keys" && has_value) {
      options.keys.folder = argv[++i];
    } else if (word == "--key" && has_value) {
      options.keys.names.emplace_back(argv[++i]);
    } else if (word == "--certificates" && has_value) {
      options.keys.certificates = argv[++i];
    } else if (word == "--socket" && has_value) {
      options.socket = argv[++i];
    } else if (word == "--version") {
      std::cout << "mbgate-signer " MBGATE_VERSION "\n";
      status = EXIT_SUCCESS;
      return std::nullopt;
    } else {
      const bool asked = word == "--help";
      (asked ? std::cout : std::cerr) << kUsage;
      status = asked ? EXIT_SUCCESS : EX_USAGE;
      return std::nullopt;
    }
  }
  if (options.keys.names.empty()) {
    options.keys.names = {"*.key"};
  }
  return options;
}

int fail(const std::string& what, int error) {
  std::cerr << "mbgate-signer: " << what << ": " << std::generic_category().message(error) << '\n';
  return -1;
}

/// The socket of systemd, if it is for this process; else -1.
int handed_over() {
  const char* const process = std::getenv("LISTEN_PID");
  const char* const count = std::getenv("LISTEN_FDS");
  const bool is_ours = process != nullptr && count != nullptr &&
                       std::to_string(::getpid()) == process && std::string_view(count) == "1";
  if (!is_ours) {
    return -1;
  }
  ::fcntl(kFirstHandedOver, F_SETFD, FD_CLOEXEC);
  ::fcntl(kFirstHandedOver, F_SETFL, O_NONBLOCK);
  return kFirstHandedOver;
}

int listen_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    return fail(path, ENAMETOOLONG);
  }
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const int listening = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  ::unlink(path.c_str());
  // As that of mbgate-signer.socket: only its owner may ask.
  const mode_t before = ::umask(0177);
  const bool bound =
      ::bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::listen(listening, kBacklog) == 0;
  const int error = errno;
  ::umask(before);
  return bound ? listening : fail(path, error);
}

/// Keys are in this memory: it is never written to a file, and no other process looks into it.
void protect() {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  ::prctl(PR_SET_DUMPABLE, 0);
}

}  // namespace

int main(int argc, char** argv) {
  mbgate::sys::open_standard_streams();
  int status = EXIT_SUCCESS;
  const auto options = options_of(argc, argv, status);
  if (!options) {
    return status;
  }
  protect();
  if (::access(options->keys.folder.c_str(), R_OK | X_OK) != 0) {
    fail(options->keys.folder, errno);
    return EX_NOINPUT;
  }
  const int listening = options->socket.empty() ? handed_over() : listen_at(options->socket);
  if (listening < 0) {
    std::cerr << (options->socket.empty()
                      ? "mbgate-signer: no socket from systemd: give --socket PATH\n"
                      : "");
    return options->socket.empty() ? EX_USAGE : EX_CANTCREAT;
  }
  sigset_t blocked;
  sigset_t waiting;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  sigaddset(&blocked, SIGINT);
  ::sigprocmask(SIG_BLOCK, &blocked, &waiting);
  struct sigaction action {};
  action.sa_handler = end;
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  if (!options->socket.empty()) {
    std::cerr << "listening " << options->socket << std::endl;
  }
  mbgate::signer::Door(listening, options->keys).run(waiting, ended);
  return EXIT_SUCCESS;
}
