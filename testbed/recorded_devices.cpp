#include "testbed/recorded_devices.hpp"

#include <string>
#include <utility>

namespace arkmesh::testbed {
namespace {

using hal::kilobot::ByteStream;

class RecordedStream final : public ByteStream {
 public:
  RecordedStream(std::unique_ptr<ByteStream> stream, std::shared_ptr<RawRecord> record)
      : stream_(std::move(stream)), record_(std::move(record)) {
    note(stream_->check());
  }
  void open() override {
    if (state_ == State::closed) record_->line_is(State::opening, {});
    stream_->open();
  }
  State check() override {
    note(stream_->check());
    return state_;
  }
  std::size_t write(std::span<const std::uint8_t> bytes) override {
    const std::size_t written = stream_->write(bytes);
    if (written > 0) record_->wrote(bytes.first(written));
    return written;
  }
  std::size_t waiting_bytes() override { return stream_->waiting_bytes(); }
  bool reset() override { return stream_->reset(); }
  const std::string& error() const override { return stream_->error(); }
  std::span<const std::uint8_t> heard() const override { return stream_->heard(); }

 private:
  void note(State now) {
    if (const auto bytes = stream_->heard(); !bytes.empty()) record_->heard(bytes);
    const std::string& why = stream_->error();
    if (now == state_ && (now != State::closed || why == why_)) return;
    state_ = now;
    why_ = why;
    record_->line_is(now, why);
  }

  std::unique_ptr<ByteStream> stream_;
  std::shared_ptr<RawRecord> record_;
  State state_ = State::closed;
  std::string why_;  // as last noted
};

class RecordedFeed final : public tracker::CameraFeed {
 public:
  RecordedFeed(std::unique_ptr<tracker::CameraFeed> feed, std::size_t camera, std::shared_ptr<RawRecord> record)
      : feed_(std::move(feed)), camera_(camera), record_(std::move(record)) {}
  cv::Mat newest() override {
    cv::Mat picture = feed_->newest();
    if (!picture.empty()) record_->picture(camera_, picture, feed_->arrival());
    return picture;
  }
  tracker::Arrival arrival() const override { return feed_->arrival(); }
  std::string error() const override { return feed_->error(); }
  hal::Counters counters() const override { return feed_->counters(); }

 private:
  std::unique_ptr<tracker::CameraFeed> feed_;
  std::size_t camera_;
  std::shared_ptr<RawRecord> record_;
};

class RecordedArena final : public hal::Arena, hal::PoseSource {
 public:
  RecordedArena(std::unique_ptr<hal::Arena> arena, std::shared_ptr<RawRecord> record)
      : record_(std::move(record)), arena_(std::move(arena)) {}
  const hal::ArenaInfo& info() const override { return arena_->info(); }
  const hal::Clock& clock() const override { return arena_->clock(); }
  hal::PoseSource& poses() override { return *this; }
  hal::RobotLink& robots() override { return arena_->robots(); }
  bool advance_to(hal::LabTime t) override {
    record_->begin();
    return arena_->advance_to(t);
  }
  void serve() override { arena_->serve(); }
  hal::TimePoint next_service() const override { return arena_->next_service(); }
  std::string waiting_for() const override { return arena_->waiting_for(); }
  bool end() override { return arena_->end(); }
  std::vector<hal::NotStanding> not_standing() const override { return arena_->not_standing(); }
  const hal::Counters& counters() const override {
    counters_ = arena_->counters();
    counters_.merge(record_->counters());
    return counters_;
  }

 private:
  std::optional<hal::PoseFrame> latest() override {
    auto frame = arena_->poses().latest();
    if (frame) record_->frame(frame->number, frame->stamp);
    return frame;
  }

  std::shared_ptr<RawRecord> record_;
  std::unique_ptr<hal::Arena> arena_;
  mutable hal::Counters counters_;
};

}  // namespace

std::unique_ptr<ByteStream> recorded(std::unique_ptr<ByteStream> stream, std::shared_ptr<RawRecord> record) {
  if (!record) return stream;
  return std::make_unique<RecordedStream>(std::move(stream), std::move(record));
}

tracker::OpenCamera recorded(tracker::OpenCamera open, std::shared_ptr<RawRecord> record) {
  if (!record) return open;
  return [open = std::move(open), record = std::move(record),
          next = std::size_t{0}](const tracker::CameraRequest& camera) mutable {
    return std::make_unique<RecordedFeed>(open(camera), next++, record);
  };
}

Observer recorded(Observer observer, std::shared_ptr<RawRecord> record) {
  if (!record) return observer;
  return [observer = std::move(observer), record = std::move(record)](const Look& look) {
    record->looked(look.now);
    if (observer) observer(look);
  };
}

std::unique_ptr<hal::Arena> recorded(std::unique_ptr<hal::Arena> arena, std::shared_ptr<RawRecord> record) {
  if (!record) return arena;
  return std::make_unique<RecordedArena>(std::move(arena), std::move(record));
}

}  // namespace arkmesh::testbed
