// SPDX-License-Identifier: Apache-2.0
// Who may look at everything that the machine remembers. tests/explore defines it and tells states
// apart by it: a member that it does not know does not compile there.
#pragma once

namespace mbgate {

struct StateReader;

}  // namespace mbgate
