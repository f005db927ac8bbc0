// SPDX-License-Identifier: Apache-2.0
// The clients of a stream of server-sent events. Used only on the thread of the HTTP interface.
#pragma once

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <fmt/core.h>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mbgate::app {

/// A client's connection to the HTTP interface, over the Unix socket or over TCP.
using ControlStream = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;

/// How long a client may take for its request, or for taking what is sent to it.
inline constexpr std::chrono::seconds kClientLimit{10};

/// The last of what is told to all who read along. Each goes on after the item that it had last,
/// and hears how many it has missed: a slow reader holds up nobody.
template <typename Item>
class Ring {
 public:
  struct Next {
    const Item& item;        ///< until the next add()
    std::uint64_t lost = 0;  ///< how many between are not there
  };

  /// The oldest make room when all together are larger than `most`; the newest one stays.
  explicit Ring(std::size_t most) : most_(most) {}

  /// Ids rise; one that is left out counts as lost.
  void add(Item item) {
    newest_ = item.id;
    size_ += item.size();
    items_.push_back(std::move(item));
    while (size_ > most_ && items_.size() > 1) {
      size_ -= items_.front().size();
      items_.pop_front();
    }
  }
  /// The id of the last one that was added; 0: there was none.
  [[nodiscard]] std::uint64_t newest() const { return newest_; }
  /// The id of the oldest one that is kept; 0: there is none.
  [[nodiscard]] std::uint64_t oldest() const { return items_.empty() ? 0 : items_.front().id; }
  /// The first one after `id` that is there. Nothing: it is still to come.
  [[nodiscard]] std::optional<Next> after(std::uint64_t id) const {
    const auto found = std::ranges::upper_bound(items_, id, {}, &Item::id);
    return found == items_.end() ? std::nullopt : std::optional(Next{*found, found->id - id - 1});
  }
  /// Nobody reads any more.
  void clear() {
    items_.clear();
    size_ = 0;
  }

 private:
  std::size_t most_;
  std::deque<Item> items_;
  std::uint64_t newest_ = 0;
  std::size_t size_ = 0;
};

class StreamReaders {
 public:
  /// There is something new for them.
  void wake();
  /// Sends what `next` gives, which is nothing if it is still to come, until the client goes or
  /// takes nothing for kClientLimit.
  boost::asio::awaitable<void> feed(ControlStream& stream, std::function<std::string()> next);

 private:
  struct Reader {
    explicit Reader(const ControlStream::executor_type& executor) : news(executor) {}
    boost::asio::steady_timer news;  ///< ends when there is something to send
    bool has_gone = false;
  };

  static void watch(ControlStream& stream, const std::shared_ptr<Reader>& reader);
  /// What `next` gives, once it gives something; nothing if the reader has gone, or something is to
  /// be sent nevertheless.
  static boost::asio::awaitable<std::string> wait_for_news(
      Reader& reader, const std::function<std::string()>& next);

  std::vector<std::weak_ptr<Reader>> readers_;  ///< feed() has them
};

// Limits the clients that follow a stream, events or the trace: each holds a descriptor as long as
// it reads. A quarter of the places, and at least one, is reserved for the Unix socket, so that
// readers over a network keep no operator out. No client has more than a quarter, or one.

class StreamPlaces {
 public:
  struct Reader {
    std::string client;  ///< what places are counted by
    bool over_tcp = false;
  };
  /// A place, as long as it is held.
  using Place = std::shared_ptr<const Reader>;

  explicit StreamPlaces(std::size_t most) : most_(most) {}

  /// Whoever has a place keeps it.
  void set_most(std::size_t most) { most_ = most; }
  /// Why there is no place; nothing if there is one.
  [[nodiscard]] std::optional<std::string> refusal(const Reader& asker) const {
    constexpr const char* kFollow = "already follow events or the trace";
    const std::size_t taken = count([](const Reader&) { return true; });
    const std::size_t over_tcp = count([](const Reader& it) { return it.over_tcp; });
    const std::size_t own = count([&](const Reader& it) { return it.client == asker.client; });
    if (taken >= most_) {
      return fmt::format("{} clients {}; [http] max_streams allows {}", taken, kFollow, most_);
    }
    if (asker.over_tcp && over_tcp >= most_ - quarter()) {
      return fmt::format("{} clients {} over TCP; [http] max_streams = {} allows {} there",
                         over_tcp, kFollow, most_, most_ - quarter());
    }
    if (own >= quarter()) {
      return fmt::format(
          "{} readers of this address or user {}; [http] max_streams = {} allows {} of each", own,
          kFollow, most_, quarter());
    }
    return std::nullopt;
  }
  /// To be taken only while there is one.
  [[nodiscard]] Place take(Reader asker) {
    std::erase_if(places_, [](const auto& place) { return place.expired(); });
    auto place = std::make_shared<const Reader>(std::move(asker));
    places_.emplace_back(place);
    return place;
  }

 private:
  template <typename Counts>
  [[nodiscard]] std::size_t count(Counts counts) const {
    return static_cast<std::size_t>(std::ranges::count_if(places_, [&](const auto& it) {
      const Place place = it.lock();
      return place && counts(*place);
    }));
  }
  [[nodiscard]] std::size_t quarter() const { return std::max<std::size_t>(most_ / 4, 1); }

  std::size_t most_;  ///< one at least
  std::vector<std::weak_ptr<const Reader>> places_;
};

}  // namespace mbgate::app
