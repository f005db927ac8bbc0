// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <iostream>

#include "app/mbgated.hpp"
#include "sys/unique_fd.hpp"

int main(int argc, char** argv) {
  mbgate::sys::open_standard_streams();
  const int status = mbgate::app::run_mbgated(argc, argv, MBGATE_VERSION);
  if (status == EXIT_SUCCESS && !std::cout.flush()) {
    std::cerr << "mbgated: standard output cannot be written\n";
    return EXIT_FAILURE;
  }
  return status;
}
