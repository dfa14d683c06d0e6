#include "tracker/camera/picture_reader.hpp"

#include <fmt/format.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "tracker/camera/jpeg_stream.hpp"
#include "tracker/camera/lower_case.hpp"

namespace arkmesh::tracker {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Kind = PictureRecord::Kind;

constexpr std::chrono::milliseconds open_limit = 4s, read_limit = 3s;
constexpr int max_torn = 1000;

template <auto release>
struct Release {
  template <typename T>
  void operator()(T* it) const {
    release(&it);
  }
};
using Format = std::unique_ptr<AVFormatContext, Release<avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, Release<avcodec_free_context>>;
using Packet = std::unique_ptr<AVPacket, Release<av_packet_free>>;
using Frame = std::unique_ptr<AVFrame, Release<av_frame_free>>;

std::int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count();
}

class Reader {
 public:
  Reader(const PictureSource& source, const TakePicture& take) : source_(source), take_(take) {}

  void run() {
    av_log_set_level(AV_LOG_QUIET);
    const std::string scheme = lower_case(source_.path.substr(0, source_.path.find(':')));
    const bool web = source_.live && (scheme == "http" || scheme == "https");
    if (web && !read_web(scheme)) return;
    read_container(scheme);
  }

 private:
  bool give(PictureRecord record, std::span<const std::uint8_t> bytes = {}) {
    record.bytes = bytes.size();
    wanted_ = wanted_ && take_(record, bytes);
    return wanted_;
  }
  void fail(const std::string& sentence) {
    give({.kind = Kind::failed}, {reinterpret_cast<const std::uint8_t*>(sentence.data()), sentence.size()});
  }
  void damaged(std::size_t count) {
    if (count > 0) give({.kind = Kind::damaged, .count = static_cast<std::int64_t>(count)});
  }

  static int late(void* reader) { return Clock::now() > static_cast<Reader*>(reader)->deadline_; }
  AVIOInterruptCB patience() { return {source_.live ? late : nullptr, this}; }
  void within(std::chrono::milliseconds limit) { deadline_ = Clock::now() + limit; }

  // Why a stream cannot be opened or read on.
  std::string reason(int error) const {
    if (Clock::now() > deadline_) error = AVERROR(ETIMEDOUT);
    const std::map<int, const char*> sentences{
        {AVERROR(ECONNREFUSED), "nothing listens at {}: is the camera on, and are its address and port right?"},
        {AVERROR_HTTP_UNAUTHORIZED,
         "the camera {} refuses the name or the password (401); give both as in http://NAME:PASSWORD@HOST/"},
        {AVERROR_HTTP_FORBIDDEN, "the camera {} forbids this page (403); ask its administrator"},
        {AVERROR_HTTP_NOT_FOUND, "there is no stream {} (404): is the path right?"},
        {AVERROR_HTTP_BAD_REQUEST, "the camera {} does not understand the request (400)"},
        {AVERROR_HTTP_OTHER_4XX, "the camera {} refuses the request (4xx)"},
        {AVERROR_HTTP_SERVER_ERROR, "the camera {} reports an error of its own (5xx); restart it"},
        {AVERROR(EHOSTUNREACH), "no route to {}: is the camera on, and in this network?"},
        {AVERROR(ENETUNREACH), "no route to {}: is this machine in the camera's network?"},
        {AVERROR(ETIMEDOUT), open_ ? "the camera {} is connected and sends no pictures"
                                   : "{} does not answer: is the camera on, and is its address right?"},
        {AVERROR_INVALIDDATA, "{} sends no readable video"}};
    const auto known = sentences.find(error);
    if (known != sentences.end()) return fmt::format(fmt::runtime(known->second), source_.shown);
    return fmt::format(fmt::runtime(open_ ? "the camera {} has ended its stream, or the connection broke"
                                          : "{} cannot be reached: is its name right, and is the camera on?"),
                       source_.shown);
  }

  // Motion JPEG over HTTP. True: it is something else.
  bool read_web(const std::string& scheme) {
    const AVIOInterruptCB patient = patience();
    AVIOContext* opened = nullptr;
    // FFmpeg knows kinds of URLs in small letters only
    const std::string url = scheme + source_.path.substr(scheme.size());
    within(open_limit);
    if (const int error = avio_open2(&opened, url.c_str(), AVIO_FLAG_READ, &patient, nullptr); error < 0) {
      fail(reason(error));
      return false;
    }
    const std::unique_ptr<AVIOContext, Release<avio_closep>> in(opened);
    open_ = true;
    std::uint8_t* told = nullptr;
    std::string type;
    if (av_opt_get(in.get(), "mime_type", AV_OPT_SEARCH_CHILDREN, &told) >= 0 && told)
      type = lower_case(reinterpret_cast<const char*>(told));
    av_free(told);
    if (type.starts_with("text/")) {
      fail(fmt::format("{} is a web page, no stream of pictures: give the address of the camera's motion JPEG or video",
                       source_.shown));
      return false;
    }
    if (!type.starts_with("multipart/") && !type.starts_with("image/jp")) return true;
    JpegStream jpegs;
    std::vector<std::uint8_t> part(64 << 10);
    give({.kind = Kind::opened});
    int error = 0;
    for (within(read_limit); wanted_;) {
      error = avio_read_partial(in.get(), part.data(), static_cast<int>(part.size()));
      if (error <= 0) break;
      jpegs.add(std::span(part).first(static_cast<std::size_t>(error)));
      while (const auto jpeg = jpegs.next()) {
        if (!give({.kind = Kind::jpeg, .time_us = now_us()}, *jpeg)) return false;
        within(read_limit);
      }
      damaged(jpegs.take_damaged());
      if (late(this)) break;
    }
    jpegs.end();
    damaged(jpegs.take_damaged());
    if (wanted_) fail(reason(error == 0 ? AVERROR_EOF : error));
    return false;
  }

  void read_container(const std::string& scheme) {
    AVFormatContext* allocated = avformat_alloc_context();
    if (!allocated) return fail("out of memory");
    allocated->interrupt_callback = patience();
    AVDictionary* options = nullptr;
    // what a file names elsewhere is not read
    if (!source_.live) av_dict_set(&options, "protocol_whitelist", "file", 0);
    if (scheme == "rtsp") av_dict_set(&options, "rtsp_transport", "tcp", 0);
    const std::string url = source_.live ? scheme + source_.path.substr(scheme.size()) : "file:" + source_.path;
    within(open_limit);
    int error = avformat_open_input(&allocated, url.c_str(), nullptr, &options);  // frees it on failure
    av_dict_free(&options);
    const Format format(error < 0 ? nullptr : allocated);
    within(open_limit);
    if (error >= 0) error = avformat_find_stream_info(format.get(), nullptr);
    const AVCodec* decoder = nullptr;
    const int video = error < 0 ? error : av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
    if (video < 0 || !decoder)
      return fail(source_.live ? reason(error < 0 && !open_ ? error : AVERROR_INVALIDDATA)
                               : fmt::format("{} is not a readable video or picture", source_.shown));
    open_ = true;
    AVStream* const stream = format->streams[video];
    for (unsigned i = 0; i < format->nb_streams; ++i)
      if (static_cast<int>(i) != video) format->streams[i]->discard = AVDISCARD_ALL;
    time_base_ = stream->time_base;
    begin_ticks_ = stream->start_time;
    if (const auto* matrix =
            reinterpret_cast<const std::int32_t*>(av_stream_get_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr)))
      if (const double turned = av_display_rotation_get(matrix); std::isfinite(turned))
        quarter_turns_ = (4 - static_cast<int>(std::lround(turned / 90))) % 4;
    const double rate = av_q2d(av_guess_frame_rate(format.get(), stream, nullptr));
    if (std::isfinite(rate) && rate > 0.01 && rate < 10'000 && !(format->iformat->flags & AVFMT_NOTIMESTAMPS))
      rate_ = rate;
    std::int64_t told = stream->nb_frames;
    if (told <= 0 && rate_ > 0 && format->duration > 0)
      told = std::llround(static_cast<double>(format->duration) / AV_TIME_BASE * rate_);
    if (!give({.kind = Kind::opened, .count = told, .pictures_per_s = rate_})) return;
    const Codec codec(avcodec_alloc_context3(decoder));
    if (!codec || avcodec_parameters_to_context(codec.get(), stream->codecpar) < 0) return fail("out of memory");
    codec->pkt_timebase = stream->time_base;
    codec->thread_count = 1;  // one that is several pictures behind would be late
    const bool jpegs = decoder->id == AV_CODEC_ID_MJPEG;
    if (!jpegs && avcodec_open2(codec.get(), decoder, nullptr) < 0)
      return fail(fmt::format("the pictures of {} cannot be decoded", source_.shown));
    const Packet packet(av_packet_alloc());
    const Frame frame(av_frame_alloc());
    std::int64_t packets = 0, last_ticks = begin_ticks_;
    int torn = 0;
    for (within(read_limit); wanted_; av_packet_unref(packet.get())) {
      error = av_read_frame(format.get(), packet.get());
      // behind a damaged place of a file there is more
      if (error == AVERROR(EAGAIN) || (error < 0 && error != AVERROR_EOF && !source_.live && ++torn < max_torn))
        continue;
      if (error < 0) break;
      if (packet->stream_index != video) continue;
      within(read_limit);
      ++packets;
      last_ticks = std::max(last_ticks, packet->pts);
      if (packet->flags & AV_PKT_FLAG_DISCARD) continue;
      if (jpegs)
        pass_on(*packet);
      else
        decode(codec.get(), packet.get(), frame.get());
    }
    if (!jpegs && wanted_) decode(codec.get(), nullptr, frame.get());
    if (!wanted_) return;
    if (source_.live) return fail(reason(error));
    // a file also counts those that its camera left out
    const double ticks =
        begin_ticks_ == AV_NOPTS_VALUE ? 0 : static_cast<double>(last_ticks) - static_cast<double>(begin_ticks_);
    const double reached = rate_ * av_q2d(time_base_) * ticks + 1;
    const auto came = std::max(packets, static_cast<std::int64_t>(std::lround(std::clamp(reached, 0.0, 1e9))));
    // a duration may be another stream's, and is rounded
    const std::int64_t promised = stream->nb_frames > 0 ? stream->nb_frames : format->nb_streams == 1u ? told - 1 : 0;
    give({.kind = Kind::ended, .count = std::max<std::int64_t>(0, promised - came)});
  }

  std::int64_t time_of(std::int64_t ticks) {
    if (source_.live) return now_us();
    const std::int64_t number = given_++;
    if (ticks == AV_NOPTS_VALUE || rate_ == 0)
      return std::llround(static_cast<double>(number) * 1e6 / (rate_ > 0 ? rate_ : 25));
    if (begin_ticks_ == AV_NOPTS_VALUE) begin_ticks_ = ticks;
    return av_rescale_q(ticks - begin_ticks_, time_base_, {1, 1'000'000});
  }

  void pass_on(const AVPacket& packet) {
    if (packet.size == 0) return;  // a picture that the camera left out
    JpegStream jpegs;
    jpegs.add({packet.data, static_cast<std::size_t>(packet.size)});
    const auto jpeg = jpegs.next();
    const std::int64_t time_us = time_of(packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts);
    if (jpeg)
      give({.kind = Kind::jpeg, .quarter_turns = quarter_turns_, .time_us = time_us}, *jpeg);
    else
      damaged(1);
  }

  // A null packet: no more will come.
  void decode(AVCodecContext* codec, const AVPacket* packet, AVFrame* frame) {
    const int taken = avcodec_send_packet(codec, packet);
    if (taken < 0 && taken != AVERROR_EOF && taken != AVERROR(EAGAIN)) return damaged(1);
    for (; wanted_; av_frame_unref(frame)) {
      const int error = avcodec_receive_frame(codec, frame);
      if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return;
      if (error < 0) return damaged(1);
      const std::int64_t time_us = time_of(frame->best_effort_timestamp);
      // part of it is what the decoder made up
      const bool whole = frame->decode_error_flags == 0 && !(frame->flags & AV_FRAME_FLAG_CORRUPT);
      if (!whole || !show(*frame, time_us)) damaged(1);
    }
  }

  bool show(const AVFrame& frame, std::int64_t time_us) {
    const int width = frame.width, height = frame.height;
    if (width < 1 || height < 1 || std::int64_t{width} * height > max_picture_pixels) return false;
    // each by its own size and format
    scaler_.reset(sws_getCachedContext(scaler_.release(), width, height, static_cast<AVPixelFormat>(frame.format),
                                       width, height, AV_PIX_FMT_BGR24, SWS_BICUBIC, nullptr, nullptr, nullptr));
    if (!scaler_) return false;
    const std::size_t row = 3 * static_cast<std::size_t>(width), stride = (row + 127) / 64 * 64;
    bgr_.resize(stride * static_cast<std::size_t>(height));
    std::uint8_t* const planes[4] = {bgr_.data()};
    const int strides[4] = {static_cast<int>(stride)};
    if (sws_scale(scaler_.get(), frame.data, frame.linesize, 0, height, planes, strides) != height) return false;
    for (std::size_t y = 1; y < static_cast<std::size_t>(height); ++y)
      std::copy_n(bgr_.begin() + static_cast<std::ptrdiff_t>(y * stride), row,
                  bgr_.begin() + static_cast<std::ptrdiff_t>(y * row));
    give({.kind = Kind::bgr,
          .width_px = width,
          .height_px = height,
          .quarter_turns = quarter_turns_,
          .time_us = time_us},
         std::span(bgr_).first(row * static_cast<std::size_t>(height)));
    return true;
  }

  struct FreeScaler {
    void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
  };

  const PictureSource& source_;
  const TakePicture& take_;
  bool wanted_ = true, open_ = false;
  Clock::time_point deadline_;
  AVRational time_base_{1, 1'000'000};
  std::int64_t begin_ticks_ = AV_NOPTS_VALUE, given_ = 0;
  int quarter_turns_ = 0;
  double rate_ = 0;
  std::unique_ptr<SwsContext, FreeScaler> scaler_;
  std::vector<std::uint8_t> bgr_;
};

}  // namespace

void read_pictures(const PictureSource& source, const TakePicture& take) {
  Reader(source, take).run();
}

}  // namespace arkmesh::tracker
