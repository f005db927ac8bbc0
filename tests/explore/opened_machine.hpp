// SPDX-License-Identifier: Apache-2.0
// The machine with nothing private, for those who read its state: the product itself names no
// friends for tests. (-fno-access-control is no help: structured bindings ask all the same, with
// g++ and clang.) Only headers of src/ are opened. What they include from elsewhere is included
// before.
//
// In the C++ ABI of Linux neither layout nor names depend on what is private here, so that this
// goes with the machine as it is built for all others. To be included before any header of the
// machine, by sources that are compiled alone (tests/CMakeLists.txt); otherwise it does not
// compile.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <boost/container/small_vector.hpp>
#include <boost/container/static_vector.hpp>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/list_hook.hpp>
#include <boost/intrusive/set.hpp>
#include <boost/intrusive/set_hook.hpp>
#include <boost/system/result.hpp>
#include <chrono>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <limits>
#include <list>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#ifdef __clang__
#pragma clang diagnostic ignored "-Wkeyword-macro"
#endif
#define private public
#include "gateway/gateway.hpp"
#undef private
