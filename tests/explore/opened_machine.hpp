// SPDX-License-Identifier: Apache-2.0
// The machine without the word private, for the sources that read its whole state: the product
// names no friends for them. g++ and clang refuse to take private members apart even with
// -fno-access-control. Only the headers of src/ are opened: what they include from elsewhere is
// included first.
//
// With g++ and clang on Linux neither the layout of a class nor any symbol depends on this. Sources
// that include it are compiled alone (tests/CMakeLists.txt).
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
