#include "server/master/picture_writer.h"

#include <chrono>
#include <utility>

#include "common/base/file.h"

namespace tessera {

namespace {
constexpr std::size_t kMaxQueuedPictures = 4;
/// Larger walls are written smaller.
constexpr double kMostPicturePixels = 4e8;
constexpr std::chrono::seconds kDiskDeadline{60};
}  // namespace

PictureWriter::PictureWriter(const Wall& wall, std::filesystem::path folder, std::uint64_t every)
    : tiles_(wall.tiles),
      layout_(wallPicture(wall, kMostPicturePixels)),
      folder_(std::move(folder)),
      every_(every) {
  thread_ = std::thread([this] { writeAll(); });
}

PictureWriter::~PictureWriter() {
  if (thread_.joinable()) (void)finish();
}

std::filesystem::path PictureWriter::pathOf(std::uint64_t frame) const {
  std::string digits = std::to_string(frame);
  digits.insert(0, digits.size() < 6 ? 6 - digits.size() : 0, '0');
  return folder_ / ("frame-" + digits + ".png");
}

bool PictureWriter::add(std::uint32_t tile, std::uint64_t frame, const proto::Picture& picture) {
  const Tile& place = tiles_[tile];
  if (picture.widthPx != place.widthPx || picture.heightPx != place.heightPx) return false;
  const std::lock_guard lock(mutex_);
  Stitched& stitched = open_[frame];
  if (stitched.parts == 0) stitched.picture = Mosaic(layout_.widthPx, layout_.heightPx, layout_.gamma);
  ++stitched.parts;
  const PicturePlace& at = layout_.tiles[tile];
  stitched.picture.add({at.corner.x(), at.corner.y(), at.across.x(), at.across.y(), at.down.x(), at.down.y()},
                       place.widthPx, place.heightPx,
                       {reinterpret_cast<const std::uint8_t*>(picture.bytes.data()), picture.bytes.size()});
  return true;
}

void PictureWriter::complete(std::uint64_t frame) {
  std::unique_lock lock(mutex_);
  while (!open_.empty() && open_.begin()->first <= frame) {
    if (!changed_.wait_for(lock, kDiskDeadline,
                           [this] { return queue_.size() < kMaxQueuedPictures || failure_; })) {
      failure_ =
          runtimeError(folder_.string(), "pictures cannot be written: the disk has not answered for 60 s");
    }
    auto next = open_.extract(open_.begin());
    if (failure_) continue;
    incomplete_ += next.mapped().parts < tiles_.size() ? 1 : 0;
    queue_.emplace_back(next.key(), std::move(next.mapped().picture));
    changed_.notify_all();
  }
}

void PictureWriter::writeAll() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return !queue_.empty() || done_; });
    if (queue_.empty()) return;
    auto [frame, mosaic] = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();
    lock.unlock();
    Result<std::string> png = encodePng(mosaic.finish());
    const Status status = png ? writeFileAtomically(pathOf(frame), *png) : Status(png.error());
    lock.lock();
    if (status) {
      ++written_;
    } else if (!failure_) {
      failure_ = status.error();
    }
  }
}

Status PictureWriter::finish() {
  complete(UINT64_MAX);
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  if (failure_) return *failure_;
  return Done{};
}

std::uint64_t PictureWriter::written() const {
  const std::lock_guard lock(mutex_);
  return written_;
}

std::uint64_t PictureWriter::incomplete() const {
  const std::lock_guard lock(mutex_);
  return incomplete_;
}

}  // namespace tessera
