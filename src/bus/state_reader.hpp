// SPDX-License-Identifier: Apache-2.0
// May read all state of the machine. tests/explore defines it to tell states apart. A member that
// tests/explore does not know is a compile error there.
#pragma once

namespace mbgate {

struct StateReader;

}  // namespace mbgate
