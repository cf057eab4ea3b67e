#include <algorithm>
#include <iterator>

#include <flatbuffers/flatbuffers.h>

#include "proto/codec.h"
#include "proto/pose_codec.h"
#include "proto/tessera_generated.h"
#include "proto/utf8.h"

namespace tessera::proto {

namespace {

using Builder = flatbuffers::FlatBufferBuilder;
template <class T>
using Offset = flatbuffers::Offset<T>;

constexpr std::size_t kSmallBytes = 512;
// At least what a record adds to a buffer, vtables and padding included, so that the buffer need not grow.
constexpr std::size_t kAssetOverheadBytes = 96;
constexpr std::size_t kLeafBytes = 520;

// The codec converts enumerations by number.
static_assert(int(wire::SurfaceKind::MAX) == int(SurfaceKind::Egl));
static_assert(int(wire::PictureFormat::MAX) == int(PictureFormat::RawRgb8));
static_assert(int(wire::AssetKind::MAX) == int(AssetKind::Image));
static_assert(int(wire::BillboardMode::MAX) == int(BillboardMode::AxialRot));
static_assert(int(wire::Pattern::MAX) == int(Pattern::Alignment));
static_assert(int(wire::OnMiss::MAX) == int(OnMiss::Skip));
static_assert(int(wire::StereoLayout::MAX) == int(StereoLayout::QuadBuffer));
static_assert(int(wire::InputKind::MAX) == int(InputKind::Gamepad));
static_assert(int(wire::ErrorCode::MAX) == int(ErrorCode::ShuttingDown));

wire::Vec3 toWire(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

wire::Vec2 toWire(const Vec2& v) {
  return {v.x(), v.y()};
}

wire::Rgb toWire(const std::array<float, 3>& rgb) {
  return {rgb[0], rgb[1], rgb[2]};
}

wire::Sha256 toWire(const Sha256& id) {
  return wire::Sha256(flatbuffers::span<const std::uint8_t, 32>(id.data(), id.size()));
}

wire::Mat4 toWire(const Mat4& m) {
  return wire::Mat4(flatbuffers::span<const double, 16>(m.data(), 16));  // Eigen stores by column
}

wire::Corners toWire(const std::array<Vec3, 4>& c) {
  return {toWire(c[0]), toWire(c[1]), toWire(c[2]), toWire(c[3])};
}

Offset<flatbuffers::Vector<const wire::Sha256*>> addIds(Builder& builder, const std::vector<Sha256>& ids) {
  std::vector<wire::Sha256> converted;
  converted.reserve(ids.size());
  for (const Sha256& id : ids)
    converted.push_back(toWire(id));
  return builder.CreateVectorOfStructs(converted);
}

Offset<flatbuffers::Vector<std::uint8_t>> addBytes(Builder& builder, std::span<const std::byte> bytes) {
  return builder.CreateVector(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

/// Ends the payload and puts its header in front; no bytes where the type does not allow as many.
template <class T>
void finishInto(Builder& builder, MessageType type, Offset<T> root, Bytes& bytes) {
  bytes.clear();
  builder.FinishSizePrefixed(root);
  const auto payload = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  if (payload.size() > maxPayloadBytes(type)) return;
  std::array<std::byte, kHeaderBytes> header = {};
  writeHeader(headerFor(type, payload), header);
  bytes.reserve(header.size() + payload.size());
  bytes.insert(bytes.end(), header.begin(), header.end());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
}

template <class T>
Bytes finish(Builder& builder, MessageType type, Offset<T> root) {
  Bytes bytes;
  finishInto(builder, type, root, bytes);
  return bytes;
}

Offset<wire::RightEye> addRightEye(Builder& builder, const std::optional<RightEye>& rightEye) {
  if (!rightEye) return {};
  const wire::Vec3 eye = toWire(rightEye->eye);
  const wire::Corners corners = toWire(rightEye->corners);
  return wire::CreateRightEye(builder, &eye, &corners);
}

Offset<wire::Frame> addFrame(Builder& builder, const Frame& frame) {
  const auto toggles = addBytes(builder, frame.toggles);
  const auto rightEye = addRightEye(builder, frame.rightEye);
  const wire::Vec3 eye = toWire(frame.eye);
  const wire::Corners corners = toWire(frame.corners);
  const wire::Vec3 right = toWire(frame.right);
  const wire::Vec3 up = toWire(frame.up);
  return wire::CreateFrame(builder, frame.frame, frame.baseFrame, &eye, &corners, frame.nearM, frame.farM,
                           &right, &up, toggles, frame.listLeafCount, frame.wantPicture, frame.overlay,
                           static_cast<wire::Pattern>(frame.pattern), frame.skewUs, rightEye,
                           static_cast<wire::StereoLayout>(frame.stereo));
}

Offset<flatbuffers::Vector<std::uint8_t>> addBytesIfAny(Builder& builder, std::span<const std::byte> bytes) {
  if (bytes.empty()) return {};
  return addBytes(builder, bytes);
}

Offset<wire::Warp> addWarp(Builder& builder, const std::optional<Warp>& warp) {
  if (!warp) return {};
  const auto uv = addBytes(builder, warp->uv);
  const auto alpha = addBytesIfAny(builder, warp->alpha);
  const auto beta = addBytesIfAny(builder, warp->beta);
  return wire::CreateWarp(builder, warp->columns, warp->rows, uv, warp->maskWidthPx, warp->maskHeightPx,
                          alpha, beta, warp->maskGamma);
}

Offset<wire::Leaf> addLeaf(Builder& builder, const LeafRecord& leaf) {
  Offset<wire::Billboard> billboard;
  if (leaf.billboard) {
    const wire::Vec3 axis = toWire(leaf.billboard->axis);
    const wire::Vec3 normal = toWire(leaf.billboard->normal);
    const wire::Vec3 position = toWire(leaf.billboard->position);
    billboard = wire::CreateBillboard(builder, static_cast<wire::BillboardMode>(leaf.billboard->mode), &axis,
                                      &normal, &position);
  }
  const wire::Sha256 drawable = toWire(leaf.drawable);
  const wire::Sha256 state = toWire(leaf.state);
  const wire::Mat4 localToWorld = toWire(leaf.localToWorld);
  const wire::Vec3 center = toWire(leaf.center);
  std::array<double, 9> columns{};
  for (std::size_t i = 0; i < 9; ++i)
    columns[i] = leaf.halfAxes[i / 3][static_cast<Eigen::Index>(i % 3)];
  const wire::Mat3 halfAxes{flatbuffers::span<const double, 9>(columns)};
  const wire::Rgb mean = toWire(leaf.meanRgb);
  return wire::CreateLeaf(builder, leaf.id, &drawable, &state, &localToWorld, &center, leaf.radius, billboard,
                          &halfAxes, &mean);
}

/// Bytes of all assets together; where they exceed any message, just more than it may hold.
std::size_t contentBytes(const Assets& message) {
  std::size_t bytes = 0;
  for (const Asset& asset : message.assets) {
    bytes = std::min<std::size_t>(bytes + asset.bytes.size(), kMaxPayloadBytes + std::size_t{1});
  }
  return bytes;
}

}  // namespace

Bytes encode(const Hello& hello) {
  Builder builder(kSmallBytes);
  const auto tileName = builder.CreateString(hello.tileName);
  const auto programVersion = builder.CreateString(hello.programVersion);
  const auto clockId = builder.CreateString(hello.clockId);
  return finish(builder, MessageType::Hello,
                wire::CreateHello(builder, tileName, programVersion, clockId,
                                  static_cast<wire::SurfaceKind>(hello.surface), hello.pid, hello.maxWidthPx,
                                  hello.maxHeightPx, hello.cacheBytes, hello.haveCount));
}

Bytes encode(const Welcome& welcome) {
  Builder builder(kSmallBytes);
  const auto wallName = builder.CreateString(welcome.wallName);
  const auto tileName = builder.CreateString(welcome.tileName);
  const wire::Rgb background(welcome.backgroundRgb[0], welcome.backgroundRgb[1], welcome.backgroundRgb[2]);
  return finish(
      builder, MessageType::Welcome,
      wire::CreateWelcome(builder, welcome.session, wallName, tileName, welcome.widthPx, welcome.heightPx,
                          welcome.xPx, welcome.yPx, welcome.idleTimeoutMs, welcome.leafCount,
                          static_cast<wire::PictureFormat>(welcome.picture), &background, welcome.wallWidthPx,
                          welcome.wallHeightPx, static_cast<wire::OnMiss>(welcome.onMiss), welcome.uploadMs));
}

Bytes encode(const Assets& assets) {
  const std::size_t assetBytes = contentBytes(assets);
  if (assetBytes > kMaxPayloadBytes || assets.assets.size() > kMaxAssetsPerMessage) return {};
  Builder builder(kSmallBytes + assetBytes + assets.assets.size() * kAssetOverheadBytes);
  std::vector<Offset<wire::Asset>> offsets;
  offsets.reserve(assets.assets.size());
  for (const Asset& asset : assets.assets) {
    const auto bytes = addBytes(builder, asset.bytes);
    const wire::Sha256 id = toWire(asset.id);
    Offset<flatbuffers::Vector<const wire::Sha256*>> needs;
    if (!asset.needs.empty()) needs = addIds(builder, asset.needs);
    offsets.push_back(wire::CreateAsset(builder, &id, static_cast<wire::AssetKind>(asset.kind), bytes,
                                        asset.diskBytes, needs));
  }
  return finish(builder, MessageType::Assets, wire::CreateAssets(builder, builder.CreateVector(offsets)));
}

Bytes encode(const Leaves& leaves) {
  if (leaves.leaves.size() > kMaxLeavesPerMessage) return {};
  Builder builder(kSmallBytes + leaves.leaves.size() * kLeafBytes);
  std::vector<Offset<wire::Leaf>> offsets;
  offsets.reserve(leaves.leaves.size());
  std::transform(leaves.leaves.begin(), leaves.leaves.end(), std::back_inserter(offsets),
                 [&](const LeafRecord& leaf) { return addLeaf(builder, leaf); });
  return finish(builder, MessageType::Leaves, wire::CreateLeaves(builder, builder.CreateVector(offsets)));
}

Bytes encode(const Have& have) {
  if (have.ids.size() > kMaxAssetsPerMessage) return {};
  Builder builder(kSmallBytes + have.ids.size() * sizeof(Sha256));
  return finish(builder, MessageType::Have, wire::CreateHave(builder, addIds(builder, have.ids)));
}

Bytes encode(const Lacks& lacks) {
  Builder builder(kSmallBytes + lacks.ids.size() * sizeof(Sha256));
  return finish(builder, MessageType::Lacks, wire::CreateLacks(builder, addIds(builder, lacks.ids)));
}

Bytes encode(const Keep& keep) {
  Builder builder(kSmallBytes + keep.leaves.size());
  return finish(builder, MessageType::Keep, wire::CreateKeep(builder, addBytes(builder, keep.leaves)));
}

Bytes encode(const Poses& poses) {
  if (poses.poses.size() > kMaxLeavesPerMessage) return {};
  Bytes bytes;
  encodePoseBytes(poses.poses, bytes);
  if (bytes.size() > maxPayloadBytes(MessageType::Poses)) return {};
  Builder builder(kSmallBytes + bytes.size());
  return finish(builder, MessageType::Poses, wire::CreatePoses(builder, addBytes(builder, bytes)));
}

Bytes encode(const Frame& frame) {
  if (frame.toggles.size() > maxPayloadBytes(MessageType::Frame)) return {};
  Builder builder(kSmallBytes + frame.toggles.size());
  return finish(builder, MessageType::Frame, addFrame(builder, frame));
}

struct Encoder::Buffers {
  Builder builder{kSmallBytes};
  Bytes bytes;
};

Encoder::Encoder() : buffers_(std::make_unique<Buffers>()) {}
Encoder::~Encoder() = default;

std::span<const std::byte> Encoder::encode(const Frame& frame) {
  if (frame.toggles.size() > maxPayloadBytes(MessageType::Frame)) return {};
  buffers_->builder.Clear();
  finishInto(buffers_->builder, MessageType::Frame, addFrame(buffers_->builder, frame), buffers_->bytes);
  return buffers_->bytes;
}

std::span<const std::byte> Encoder::encode(const Swap& swap) {
  buffers_->builder.Clear();
  finishInto(buffers_->builder, MessageType::Swap, wire::CreateSwap(buffers_->builder, swap.frame),
             buffers_->bytes);
  return buffers_->bytes;
}

Bytes encode(const Ready& ready) {
  Builder builder(kSmallBytes);
  return finish(builder, MessageType::Ready,
                wire::CreateReady(builder, ready.frame, ready.drawUs, ready.leafCount, ready.missingLeaves,
                                  ready.missingPx));
}

Bytes encode(const Swap& swap) {
  Builder builder(kSmallBytes);
  return finish(builder, MessageType::Swap, wire::CreateSwap(builder, swap.frame));
}

Bytes encode(const Shown& shown) {
  const std::size_t pictureBytes = shown.picture ? shown.picture->bytes.size() : 0;
  if (pictureBytes > kMaxPayloadBytes) return {};
  Builder builder(kSmallBytes + pictureBytes);
  Offset<wire::Picture> picture;
  if (shown.picture) {
    const auto bytes = addBytes(builder, shown.picture->bytes);
    picture = wire::CreatePicture(builder, shown.picture->widthPx, shown.picture->heightPx,
                                  static_cast<wire::PictureFormat>(shown.picture->format), bytes);
  }
  return finish(builder, MessageType::Shown, wire::CreateShown(builder, shown.frame, shown.shownNs, picture));
}

Bytes encode(const Ping& ping) {
  Builder builder(kSmallBytes);
  return finish(builder, MessageType::Ping, wire::CreatePing(builder, ping.nonce));
}

Bytes encode(const Pong& pong) {
  Builder builder(kSmallBytes);
  return finish(builder, MessageType::Pong, wire::CreatePong(builder, pong.nonce));
}

Bytes encode(const Bye& bye) {
  Builder builder(kSmallBytes);
  const auto reason = builder.CreateString(fitUtf8(bye.reason, kMaxTextBytes));
  return finish(builder, MessageType::Bye,
                wire::CreateBye(builder, reason, bye.peakResidentBytes, bye.framesShown));
}

Bytes encode(const ErrorMessage& error) {
  Builder builder(kSmallBytes);
  const auto text = builder.CreateString(fitUtf8(error.text, kMaxTextBytes));
  return finish(builder, MessageType::Error,
                wire::CreateError(builder, static_cast<wire::ErrorCode>(error.code), text));
}

Bytes encode(const TileSetup& setup) {
  std::size_t warpBytes = 0;
  if (setup.warp) {
    for (const auto& bytes : {setup.warp->uv, setup.warp->alpha, setup.warp->beta}) {
      if (bytes.size() > maxPayloadBytes(MessageType::TileSetup)) return {};
      warpBytes += bytes.size();
    }
  }
  Builder builder(kSmallBytes + warpBytes);
  const auto screenName = builder.CreateString(setup.screenName);
  const auto warp = addWarp(builder, setup.warp);
  const auto& c = setup.cornersM;
  const wire::FlatCorners corners(toWire(c[0]), toWire(c[1]), toWire(c[2]), toWire(c[3]));
  const wire::Rgb gain = toWire(setup.gainRgb);
  const wire::Rgb black = toWire(setup.blackRgb);
  const wire::Edges blend(setup.blendPx[0], setup.blendPx[1], setup.blendPx[2], setup.blendPx[3]);
  return finish(builder, MessageType::TileSetup,
                wire::CreateTileSetup(builder, screenName, setup.screenWidthM, setup.screenHeightM, &corners,
                                      &gain, &black, setup.gamma, &blend, warp));
}

Bytes encode(const Input& input) {
  Builder builder(kSmallBytes);
  const wire::Axes axes(flatbuffers::span<const float, 6>(input.axes.data(), input.axes.size()));
  return finish(builder, MessageType::Input,
                wire::CreateInput(builder, static_cast<wire::InputKind>(input.kind), input.code,
                                  input.pressed, input.modifiers, input.x, input.y, &axes, input.buttons));
}

}  // namespace tessera::proto
