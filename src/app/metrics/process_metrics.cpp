// SPDX-License-Identifier: Apache-2.0
// What every Prometheus client shows of its process, by the same names.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "app/metrics/metric_book.hpp"
#include "app/metrics/metrics.hpp"

namespace mbgate::app {
namespace {

double cpu_seconds(const timeval& time) {
  constexpr double kMicro = 1e-6;
  return static_cast<double>(time.tv_sec) + kMicro * static_cast<double>(time.tv_usec);
}

void add_cpu(MetricBook& book) {
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) == 0) {
    book.counter({"process_cpu_seconds_total", "User and system time of the process."}, {},
                 cpu_seconds(usage.ru_utime) + cpu_seconds(usage.ru_stime));
  }
}

void add_descriptors(MetricBook& book) {
  std::error_code failed;
  const std::filesystem::directory_iterator open("/proc/self/fd", failed);
  if (!failed) {
    // The folder itself is open while it is read.
    book.gauge({"process_open_fds", "Open file descriptors."}, {},
               std::distance(begin(open), end(open)) - 1);
  }
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0) {
    book.gauge({"process_max_fds", "The most file descriptors that may be open."}, {},
               limit.rlim_cur);
  }
}

// Alerts on restarts compare it from scrape to scrape, and two clocks never say the same twice: it
// is to be asked for once.
double start_seconds(double ticks_after_boot) {
  constexpr double kNano = 1e-9;
  timespec boot{};
  ::clock_gettime(CLOCK_BOOTTIME, &boot);
  const double since_boot =
      static_cast<double>(boot.tv_sec) + kNano * static_cast<double>(boot.tv_nsec);
  const double age = since_boot - ticks_after_boot / static_cast<double>(::sysconf(_SC_CLK_TCK));
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count() - age;
}

// proc(5), /proc/pid/stat: 22 starttime, 23 vsize, 24 rss; the name in brackets may hold spaces.
void add_memory_and_start(MetricBook& book) {
  std::ifstream file("/proc/self/stat");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) {
    return;
  }
  std::istringstream rest(text.substr(name_end + 1));
  constexpr int kBefore = 19;  // fields 3 to 21
  std::string skipped;
  for (int field = 0; field < kBefore; ++field) {
    rest >> skipped;
  }
  double start_ticks = 0;
  double virtual_bytes = 0;
  double resident_pages = 0;
  if (!(rest >> start_ticks >> virtual_bytes >> resident_pages)) {
    return;
  }
  book.gauge({"process_virtual_memory_bytes", "Address space in use."}, {}, virtual_bytes);
  book.gauge({"process_resident_memory_bytes", "Memory in use."}, {},
             resident_pages * static_cast<double>(::sysconf(_SC_PAGESIZE)));
  static const double kStart = start_seconds(start_ticks);
  book.gauge({"process_start_time_seconds", "When the process began, since 1970."}, {}, kStart);
}

}  // namespace

std::vector<prometheus::MetricFamily> process_families() {
  MetricBook book;
  add_cpu(book);
  add_descriptors(book);
  add_memory_and_start(book);
  return book.take();
}

}  // namespace mbgate::app
