// SPDX-License-Identifier: Apache-2.0
// Starts a coroutine whose failure cannot go unnoticed. Asio's `detached` swallows exceptions. Here
// an exception that leaves the coroutine comes out of io_context::run(), with the name of the
// coroutine before its text.
#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace mbgate::io {

/// `name` says in the error text which coroutine failed.
void supervise(boost::asio::io_context& context, boost::asio::awaitable<void> coroutine,
               const char* name);

/// A call of Asio that is awaited returns its error beside its result, instead of throwing it.
inline constexpr auto kAsTuple = boost::asio::as_tuple(boost::asio::use_awaitable);

}  // namespace mbgate::io
