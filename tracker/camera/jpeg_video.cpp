#include "tracker/camera/jpeg_video.hpp"

#include <fmt/format.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <vector>

namespace arkmesh::tracker {
namespace {

constexpr int jpeg_quality = 95;

}  // namespace

struct JpegVideo::File {
  File() = default;
  ~File() {
    if (stream) av_write_trailer(format);
    if (format) avio_closep(&format->pb);
    avformat_free_context(format);
    av_packet_free(&packet);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  bool open(const std::string& name, cv::Size size, AVRational per_s) {
    av_log_set_level(AV_LOG_QUIET);
    if (!packet || avformat_alloc_output_context2(&format, nullptr, "avi", nullptr) < 0 ||
        avio_open(&format->pb, ("file:" + name).c_str(), AVIO_FLAG_WRITE) < 0)
      return false;
    format->flags |= AVFMT_FLAG_BITEXACT;
    AVStream* const begun = avformat_new_stream(format, nullptr);
    if (!begun) return false;
    begun->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
    begun->codecpar->codec_id = AV_CODEC_ID_MJPEG;
    begun->codecpar->width = size.width;
    begun->codecpar->height = size.height;
    begun->time_base = ticks = av_inv_q(per_s);
    begun->avg_frame_rate = per_s;
    if (avformat_write_header(format, nullptr) < 0) return false;
    stream = begun;
    return true;
  }

  AVFormatContext* format = nullptr;
  AVStream* stream = nullptr;  // once the head is written
  AVPacket* packet = av_packet_alloc();
  AVRational ticks{};
};

JpegVideo::JpegVideo(const std::string& file, cv::Size size, double pictures_per_s)
    : name_(file), file_(std::make_unique<File>()) {
  if (!file_->open(file, size, av_d2q(pictures_per_s, 1'000'000)))
    throw std::runtime_error(
        fmt::format("cannot write the video {}; does the folder exist, and does the disk have free space?", file));
}

JpegVideo::~JpegVideo() = default;

void JpegVideo::write(const cv::Mat& bgr) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
  AVPacket& packet = *file_->packet;
  packet.data = jpeg.data();
  packet.size = static_cast<int>(jpeg.size());
  packet.pts = packet.dts = av_rescale_q(pictures_++, file_->ticks, file_->stream->time_base);
  packet.duration = av_rescale_q(1, file_->ticks, file_->stream->time_base);
  packet.flags = AV_PKT_FLAG_KEY;
  const int error = av_write_frame(file_->format, &packet);
  av_packet_unref(&packet);
  if (error < 0) throw std::runtime_error(fmt::format("cannot continue to write {}; is the disk full?", name_));
}

}  // namespace arkmesh::tracker
