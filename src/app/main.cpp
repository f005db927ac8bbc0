// SPDX-License-Identifier: Apache-2.0
#include "app/mbgated.hpp"

int main(int argc, char** argv) { return mbgate::app::run_mbgated(argc, argv, MBGATE_VERSION); }
