// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fmt/core.h>
#include <fstream>
#include <iterator>
#include <sstream>

#include "base/text.hpp"
#include "ctl/doctor/findings.hpp"
#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kPermissionBits = 07777;

std::string name_of_user(uid_t user) {
  const auto* entry = ::getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

std::string name_of_group(gid_t group) {
  const auto* entry = ::getgrgid(group);
  return entry != nullptr ? entry->gr_name : std::to_string(group);
}

bool is_process_in(gid_t group) {
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(::getgroups(0, nullptr), 0)));
  const int count = ::getgroups(static_cast<int>(groups.size()), groups.data());
  groups.resize(static_cast<std::size_t>(std::max(count, 0)));
  return group == ::getegid() || std::ranges::find(groups, group) != groups.end();
}

bool is_listed_in(gid_t group, const std::string& user) {
  const auto* entry = ::getgrgid(group);
  if (entry == nullptr) {
    return false;
  }
  char** member = entry->gr_mem;
  while (*member != nullptr && user != *member) {
    ++member;
  }
  return *member != nullptr;
}

/// "/dev/ttyUSB0" for every name that leads there.
std::string real_path(const std::string& device) {
  std::error_code error;
  const auto path = fs::canonical(device, error);
  return error ? device : path.string();
}

std::string line_of_file(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

Holder holder_of(int process) {
  return {process, line_of_file(fmt::format("/proc/{}/comm", process))};
}

/// As /proc/locks names a file: "00:06:123", the device in hexadecimal, and the inode.
std::string lock_name(const struct stat& status) {
  return fmt::format("{:02x}:{:02x}:{}", major(status.st_dev), minor(status.st_dev), status.st_ino);
}

bool has_open(const std::string& process, dev_t port) {
  return std::ranges::any_of(paths_in(process + "/fd"), [&](const std::string& path) {
    // Not stat() for every file: on a network that is gone it blocks.
    std::error_code unreadable;
    const auto target = fs::read_symlink(path, unreadable);
    struct stat status {};
    return !unreadable && target.string().starts_with("/dev/") &&
           ::stat(path.c_str(), &status) == 0 && S_ISCHR(status.st_mode) && status.st_rdev == port;
  });
}

}  // namespace

PortFacts look_at_port(const std::string& device) {
  PortFacts facts;
  struct stat status {};
  facts.error = ::stat(device.c_str(), &status) == 0 ? 0 : errno;
  facts.is_character_device = facts.error == 0 && S_ISCHR(status.st_mode);
  facts.names = paths_in();
  std::ranges::copy_if(facts.names, std::back_inserter(facts.leading),
                       [&](const auto& name) { return lasting_name(device, {name}).has_value(); });
  facts.is_lasting = std::ranges::find(facts.names, device) != facts.names.end();
  return facts;
}

PermissionFacts look_at_permission(const std::string& device) {
  PermissionFacts facts;
  const bool may = ::faccessat(AT_FDCWD, device.c_str(), R_OK | W_OK, AT_EACCESS) == 0;
  facts.error = may ? 0 : errno;
  facts.user = name_of_user(::geteuid());
  struct stat status {};
  if (::stat(device.c_str(), &status) == 0) {
    facts.owner = name_of_user(status.st_uid);
    facts.group = name_of_group(status.st_gid);
    facts.mode = status.st_mode & kPermissionBits;
    facts.is_member = is_process_in(status.st_gid);
    facts.becomes_member = is_listed_in(status.st_gid, facts.user);
  }
  return facts;
}

std::vector<Holder> find_holders(const std::string& device) {
  std::vector<Holder> holders;
  struct stat port {};
  if (::stat(device.c_str(), &port) != 0) {
    return holders;
  }
  for (const auto& path : paths_in("/proc")) {
    const auto process = integer_in<int>(path.substr(path.rfind('/') + 1));
    if (process && *process != ::getpid() && has_open(path, port.st_rdev)) {
      holders.push_back(holder_of(*process));
    }
  }
  std::ranges::sort(holders, {}, &Holder::process);
  return holders;
}

std::vector<Holder> find_lock_holders(const std::string& device) {
  struct stat status {};
  if (::stat(device.c_str(), &status) != 0) {
    return {};
  }
  const auto wanted = lock_name(status);
  std::ifstream locks("/proc/locks");
  // "1: FLOCK  ADVISORY  WRITE 1234 00:06:123 0 EOF"
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string skipped;
    std::string kind;
    std::string file;
    int process = 0;
    const bool whole{words >> skipped >> kind >> skipped >> skipped >> process >> file};
    if (whole && kind == "FLOCK" && file == wanted && process > 0) {
      return {holder_of(process)};
    }
  }
  return find_holders(device);
}

LatencyFacts look_at_latency(const std::string& device) {
  const auto path = real_path(device);
  const auto name = path.substr(path.rfind('/') + 1);
  const auto text = line_of_file(fmt::format("/sys/class/tty/{}/device/latency_timer", name));
  LatencyFacts facts{path};
  if (const auto timer = integer_in<int>(text); timer && *timer >= 0) {
    facts.timer = static_cast<unsigned>(*timer);
  }
  return facts;
}

bool is_pseudo_terminal(const std::string& device) {
  return real_path(device).starts_with("/dev/pts/");
}

}  // namespace mbgate::ctl
