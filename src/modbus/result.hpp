// SPDX-License-Identifier: Apache-2.0
// The result of a function whose input may be wrong: a value, or the reason why there is none.
#pragma once

#include <boost/system/result.hpp>

namespace mbgate {

template <typename Value, typename Error>
using Result = boost::system::result<Value, Error>;

}  // namespace mbgate
