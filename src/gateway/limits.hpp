// SPDX-License-Identifier: Apache-2.0
// Every fixed limit of the machine, each with its reason. What a user may want to change is a
// setting instead.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "bus/instant.hpp"

namespace mbgate::gateway {

/// The driver reads a socket in pieces of at most this size.
inline constexpr std::size_t kClientReadSize = 2048;

/// And what a client that has gone has left there at most this far, for a stop may be among it.
/// More than 64 requests of any size.
inline constexpr std::size_t kClientLastSize = 32768;

/// Requests of a connection that may be unanswered, more than any client waits for; with answers
/// that were not sent yet so many that its socket is not read.
inline constexpr std::size_t kRequestsOutstanding = 64;

/// Transactions of the requests of all connections that may be outstanding: about 64 MB. Requests
/// beyond that get 06.
inline constexpr std::size_t kTransactionsOfAll = 32768;

/// The same of one connection: the connections of one client address hold half of all.
inline constexpr std::size_t kTransactionsOfOne = 256;

/// Writes wait at most for two transactions of the bus, the running one and one that goes before
/// them, and 0.5 s. Not longer, because an old motion command is dangerous.
constexpr bus::Duration write_deadline(bus::Duration longest_transaction) {
  constexpr int kTransactions = 2;
  constexpr auto kMargin = std::chrono::milliseconds(500);
  return kTransactions * longest_transaction + kMargin;
}

/// Reads wait this long for their turn: longer than any operator panel waits, and never less than
/// writes.
constexpr bus::Duration read_deadline(bus::Duration longest_transaction) {
  return std::max<bus::Duration>(std::chrono::seconds(5), write_deadline(longest_transaction));
}

/// Clients that are remembered because it was reported that they ask for a unit without a route:
/// more than a plant has, few enough to be kept.
inline constexpr std::size_t kUnroutedTold = 256;

/// Client addresses whose requests are counted because a rule has a rate: each is forgotten within
/// a second after its last request, so that only a flood comes so far. Then others get 06.
inline constexpr std::size_t kRatedClients = 4096;

/// What a client does that the journal is told of is counted anew after this time: so often it is
/// reported for each client (the limits below), and how often it was not is said with the next one.
inline constexpr bus::Duration kReportedEvery = std::chrono::minutes(1);

/// Denied reads, and denied writes: a program that may not do something tries again and again.
inline constexpr unsigned kDenialsReported = 1;

/// What has to be found afterwards (denied stops, cleared counters, logins): as many as the log
/// takes of one kind.
inline constexpr unsigned kActsReported = 10;

/// Clients for which that is counted apart, for each kind: as kUnroutedTold. Others are counted as
/// one.
inline constexpr std::size_t kReportedClients = 256;

/// Values of a write that the journal is told: a position, a speed and their like; a recording has
/// all of them.
inline constexpr std::size_t kToldValues = 8;

/// Letters of a name in a certificate that the journal is told: the longest common name has as many
/// (RFC 5280, ub-common-name).
inline constexpr std::size_t kToldName = 64;

/// A deadline that is so late is missed: longer than a loaded machine keeps a process waiting.
inline constexpr bus::Duration kOverdue = std::chrono::seconds(1);

/// After a shutdown was asked for, what is on the wire has this long: the process ends within 2 s.
inline constexpr bus::Duration kShutdownGrace = std::chrono::milliseconds(1500);

}  // namespace mbgate::gateway
