// SPDX-License-Identifier: Apache-2.0
#include "bus/sharing/shared_read.hpp"

#include <algorithm>

#include "bus/sharing/read_cache.hpp"
#include "drive/register_range.hpp"
#include "modbus/make_request.hpp"

namespace mbgate::bus {
namespace {

using modbus::Table;
using modbus::TableRange;

constexpr unsigned kBitsPerByte = 8;
constexpr std::size_t kData = 2;  // after function and byte count (6.1 to 6.4)

bool is_bits(Table table) { return table == Table::coils || table == Table::discrete_inputs; }

bool same_request(const Transaction& a, const Transaction& b) {
  return a.address == b.address && a.request.pdu() == b.request.pdu();
}

// Collects the jobs that join; they are taken out of the queue when it is not looked at any more.
class Gathering {
 public:
  Gathering(BusQueue& queue, Transmission& transmission, const drive::Device& device,
            Sharing sharing)
      : queue_(queue),
        transmission_(transmission),
        leader_(*transmission.leader),
        device_(device),
        sharing_(sharing),
        merges_(sharing.merge && can_merge(leader_)) {
    if (merges_) {
      range_ = leader_.transaction().request.reads()->range;
    }
  }

  // A merged read grows with each that joins, so that others may come to touch it.
  void run() {
    std::size_t before = 0;
    do {
      before = joined_.size();
      queue_.visit_fronts(leader_.address(), [this](Job& job) { return visit(job); });
    } while (merges_ && joined_.size() > before);
    for (Job* job : joined_) {
      queue_.remove(*job);
      transmission_.followers.push_back(job);
    }
    const bool differ =
        std::ranges::any_of(joined_, [this](const Job* job) { return !is_identical(*job); });
    if (differ) {
      transmission_.merged =
          std::make_unique<Transaction>(leader_.address(), modbus::make_read(range_));
      transmission_.merged->unit = leader_.transaction().unit;
    }
  }

 private:
  static bool can_merge(const Job& job) {
    return ReadCache::can_hold(job.transaction().request) && !job.unmerged;
  }

  // True: the next job of the same client address may join too.
  bool visit(Job& job) {
    if (std::ranges::find(joined_, &job) != joined_.end()) {
      return true;
    }
    const bool fits = job.is_single_read() && !crosses_write(job) && has_same_unit(job) &&
                      ((sharing_.coalesce && is_identical(job)) || grows_with(job));
    if (fits) {
      joined_.push_back(&job);
    }
    return fits;
  }

  [[nodiscard]] bool is_identical(const Job& job) const {
    return same_request(job.transaction(), leader_.transaction());
  }

  // One device is asked by several units. Should these be drives after all, each answers for
  // itself.
  [[nodiscard]] bool has_same_unit(const Job& job) const {
    return job.transaction().unit == leader_.transaction().unit;
  }

  [[nodiscard]] bool crosses_write(const Job& job) const {
    const auto [first, last] = std::minmax(job.sequence, leader_.sequence);
    return queue_.write_waits_between(leader_.address(), first, last);
  }

  bool grows_with(const Job& job) {
    if (!merges_ || !can_merge(job)) {
      return false;
    }
    const Transaction& mine = leader_.transaction();
    const Transaction& other = job.transaction();
    const TableRange& range = other.request.reads()->range;
    const std::uint32_t begin = std::min(range_.first, range.first);
    const std::uint32_t end = std::max(drive::end_of(range_), drive::end_of(range));
    const bool touching =
        range.first <= drive::end_of(range_) && range_.first <= drive::end_of(range);
    if (other.request.function() != mine.request.function() || !touching ||
        other.window_begin != mine.window_begin || other.window_end != mine.window_end ||
        !device_takes(begin, end)) {
      return false;
    }
    range_ = {range_.table, static_cast<std::uint16_t>(begin),
              static_cast<std::uint16_t>(end - begin)};
    return true;
  }

  // Never over the limits, through a value, across a parameter group or over write-only registers.
  [[nodiscard]] bool device_takes(std::uint32_t begin, std::uint32_t end) const {
    const drive::Profile& profile = device_.profile;
    const Table table = range_.table;
    if (end - begin > profile.limits.read_from(table) || profile.group_end(table, begin) < end) {
      return false;
    }
    const TableRange whole{table, static_cast<std::uint16_t>(begin),
                           static_cast<std::uint16_t>(end - begin)};
    const auto cuts = [&](std::uint32_t at) {
      const drive::Value* value = profile.values.at(table, at);
      return value != nullptr && value->first < at;
    };
    return !cuts(begin) && !cuts(end) && !drive::touches(profile.write_only, whole);
  }

  BusQueue& queue_;
  Transmission& transmission_;
  const Job& leader_;
  const drive::Device& device_;
  Sharing sharing_;
  bool merges_;
  TableRange range_{};
  boost::container::small_vector<Job*, 8> joined_;
};

}  // namespace

void gather_followers(BusQueue& queue, Transmission& transmission, const drive::Device& device,
                      Sharing sharing) {
  if (transmission.leader->is_single_read() && (sharing.coalesce || sharing.merge)) {
    Gathering(queue, transmission, device, sharing).run();
  }
}

modbus::Pdu part_of(const modbus::Pdu& response, const TableRange& whole, const TableRange& part) {
  const unsigned offset = unsigned{part.first} - whole.first;
  const modbus::Bytes data = response.bytes().subspan(kData);
  boost::container::static_vector<std::uint8_t, modbus::kMaxPduSize> bytes{response.function(), 0};
  if (is_bits(whole.table)) {
    bytes.resize(kData + (part.count + kBitsPerByte - 1U) / kBitsPerByte, 0);
    for (unsigned at = 0; at < part.count; ++at) {
      const unsigned from = offset + at;
      const unsigned bit = (unsigned{data[from / kBitsPerByte]} >> (from % kBitsPerByte)) & 1U;
      bytes[kData + at / kBitsPerByte] |= static_cast<std::uint8_t>(bit << (at % kBitsPerByte));
    }
  } else {
    const modbus::Bytes wanted = data.subspan(std::size_t{offset} * 2, std::size_t{part.count} * 2);
    bytes.insert(bytes.end(), wanted.begin(), wanted.end());
  }
  bytes[1] = static_cast<std::uint8_t>(bytes.size() - kData);
  return *modbus::Pdu::from({bytes.data(), bytes.size()});
}

}  // namespace mbgate::bus
