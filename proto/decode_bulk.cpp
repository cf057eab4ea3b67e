#include <algorithm>

#include "proto/codec.h"
#include "proto/decode_check.h"
#include "proto/pose_codec.h"

namespace tessera::proto {

namespace {

// The least that an element takes in an honest payload: its place in the vector, its vtable offset and its
// required structs. Offsets that share a table would let a small payload become a large message.
constexpr std::size_t kMinAssetBytes = 4 + 4 + 32 + 4 + 4;
constexpr std::size_t kMinLeafBytes = 4 + 4 + 32 + 32 + 128 + 24;

constexpr std::uint32_t kMaxAssetTables = 1 + kMaxAssetsPerMessage;
constexpr std::uint32_t kMaxLeafTables = 1 + 2 * kMaxLeavesPerMessage;

constexpr double kAxisTolerance = 1e-6;

bool areImageAxes(const Vec3& right, const Vec3& up) {
  return std::abs(right.squaredNorm() - 1) <= kAxisTolerance &&
         std::abs(up.squaredNorm() - 1) <= kAxisTolerance && std::abs(right.dot(up)) <= kAxisTolerance;
}

std::optional<LeafBillboard> billboardOf(DecodeCheck& check, const wire::Billboard* billboard) {
  if (billboard == nullptr) return std::nullopt;
  return LeafBillboard{
      .mode = check.enumeration(billboard->mode(), BillboardMode::AxialRot, "billboard.mode"),
      .axis = check.vec3(billboard->axis(), "billboard.axis"),
      .normal = check.vec3(billboard->normal(), "billboard.normal"),
      .position = check.vec3(billboard->position_m(), "billboard.position_m")};
}

std::vector<Sha256> idsOf(DecodeCheck& check, const flatbuffers::Vector<const wire::Sha256*>* ids,
                          std::size_t most, std::string_view field) {
  std::vector<Sha256> read;
  if (ids == nullptr || !check.require(ids->size() <= most, ProtocolError::BadCount, field)) return read;
  read.reserve(ids->size());
  for (const wire::Sha256* id : *ids)
    read.push_back(sha256Of(id));
  return read;
}

LeafRecord leafOf(DecodeCheck& check, const wire::Leaf& leaf) {
  check.require(leaf.radius_m() >= 0, ProtocolError::BadNumber, "radius_m");
  std::array<Vec3, 3> halfAxes = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  if (leaf.half_axes_m()) {
    const wire::Mat3 copy = DecodeCheck::copyOf(leaf.half_axes_m());
    for (std::uint16_t i = 0; i < 9; ++i)
      halfAxes[i / 3][i % 3] = check.finite(copy.column_major()->Get(i), "half_axes_m");
  }
  std::array<float, 3> mean = {0, 0, 0};
  if (leaf.mean()) mean = {leaf.mean()->r(), leaf.mean()->g(), leaf.mean()->b()};
  for (const float channel : mean)
    check.require(channel >= 0 && channel <= 1, ProtocolError::BadNumber, "mean");
  return {.id = leaf.id(),
          .drawable = sha256Of(leaf.drawable()),
          .state = sha256Of(leaf.state()),
          .localToWorld = check.mat4(leaf.local_to_world(), "local_to_world"),
          .center = check.vec3(leaf.center_m(), "center_m"),
          .radius = check.finite(leaf.radius_m(), "radius_m"),
          .halfAxes = halfAxes,
          .meanRgb = mean,
          .billboard = billboardOf(check, leaf.billboard())};
}

std::optional<RightEye> rightEyeOf(DecodeCheck& check, const wire::RightEye* rightEye) {
  if (rightEye == nullptr) return std::nullopt;
  return RightEye{.eye = check.vec3(rightEye->eye_m(), "right_eye.eye_m"),
                  .corners = check.corners(rightEye->corners_m(), "right_eye.corners_m")};
}

Picture pictureOf(DecodeCheck& check, const wire::Picture& picture) {
  const Picture read = {.widthPx = check.imagePx(picture.width_px(), "width_px"),
                        .heightPx = check.imagePx(picture.height_px(), "height_px"),
                        .format = check.enumeration(picture.format(), PictureFormat::RawRgb8, "format"),
                        .bytes = bytesOf(picture.bytes())};
  check.require(read.format != PictureFormat::None, ProtocolError::BadEnum, "format");
  if (check.ok()) {
    const auto pixels = static_cast<std::size_t>(read.widthPx) * static_cast<std::size_t>(read.heightPx);
    check.require(read.bytes.size() == 3 * pixels, ProtocolError::BadPicture, "bytes");
  }
  return read;
}

}  // namespace

Result<Assets> decodeAssets(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Assets);
  const auto* wireAssets = check.root<wire::Assets>(payload, kMaxAssetTables);
  if (wireAssets == nullptr) return check.error();
  const std::size_t count = wireAssets->assets()->size();
  if (!check.require(count <= payload.size() / kMinAssetBytes, ProtocolError::BadCount, "assets")) {
    return check.error();
  }
  Assets assets;
  assets.assets.reserve(count);
  std::size_t assetBytes = 0;
  for (const wire::Asset* asset : *wireAssets->assets()) {
    const Asset& read =
        assets.assets.emplace_back(Asset{.id = sha256Of(asset->id()),
                                         .kind = check.enumeration(asset->kind(), AssetKind::Image, "kind"),
                                         .bytes = bytesOf(asset->bytes()),
                                         .diskBytes = asset->disk_bytes(),
                                         .needs = idsOf(check, asset->needs(), kMaxAssetNeeds, "needs")});
    check.require(read.diskBytes == 0 || (read.bytes.empty() && read.diskBytes <= kMaxAssetBytes),
                  ProtocolError::BadNumber, "disk_bytes");
    check.require(read.needs.empty() || read.kind == AssetKind::State, ProtocolError::BadCount, "needs");
    assetBytes += read.bytes.size() + read.needs.size() * sizeof(Sha256);
  }
  check.require(assetBytes <= payload.size(), ProtocolError::BadCount, "bytes");
  return check.finish(std::move(assets));
}

Result<Leaves> decodeLeaves(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Leaves);
  const auto* wireLeaves = check.root<wire::Leaves>(payload, kMaxLeafTables);
  if (wireLeaves == nullptr) return check.error();
  const std::size_t count = wireLeaves->leaves()->size();
  const std::size_t limit = std::min(kMaxLeavesPerMessage, payload.size() / kMinLeafBytes);
  if (!check.require(count <= limit, ProtocolError::BadCount, "leaves")) return check.error();
  Leaves leaves;
  leaves.leaves.reserve(count);
  for (const wire::Leaf* leaf : *wireLeaves->leaves())
    leaves.leaves.push_back(leafOf(check, *leaf));
  return check.finish(std::move(leaves));
}

Result<Frame> decodeFrame(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Frame);
  const auto* wireFrame = check.root<wire::Frame>(payload);
  if (wireFrame == nullptr) return check.error();
  const Frame frame = {.frame = check.frameNumber(wireFrame->frame()),
                       .baseFrame = wireFrame->base_frame(),
                       .eye = check.vec3(wireFrame->eye_m(), "eye_m"),
                       .corners = check.corners(wireFrame->corners_m(), "corners_m"),
                       .nearM = check.finite(wireFrame->near_m(), "near_m"),
                       .farM = check.finite(wireFrame->far_m(), "far_m"),
                       .right = check.vec3(wireFrame->right(), "right"),
                       .up = check.vec3(wireFrame->up(), "up"),
                       .toggles = bytesOf(wireFrame->toggles()),
                       .listLeafCount = wireFrame->list_leaf_count(),
                       .wantPicture = wireFrame->want_picture(),
                       .overlay = wireFrame->overlay(),
                       .pattern = check.enumeration(wireFrame->pattern(), Pattern::Alignment, "pattern"),
                       .skewUs = wireFrame->skew_us(),
                       .rightEye = rightEyeOf(check, wireFrame->right_eye()),
                       .stereo = check.enumeration(wireFrame->stereo(), StereoLayout::QuadBuffer, "stereo")};
  check.require(frame.rightEye.has_value() == (frame.stereo != StereoLayout::None), ProtocolError::BadEnum,
                "stereo");
  check.require(frame.baseFrame < frame.frame, ProtocolError::BadNumber, "base_frame");
  check.require(0 < frame.nearM && frame.nearM < frame.farM, ProtocolError::BadDepthRange);
  check.require(areImageAxes(frame.right, frame.up), ProtocolError::BadAxes);
  return check.finish(frame);
}

Result<Have> decodeHave(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Have);
  const auto* have = check.root<wire::Have>(payload);
  if (have == nullptr) return check.error();
  return check.finish(Have{idsOf(check, have->ids(), kMaxAssetsPerMessage, "ids")});
}

Result<Lacks> decodeLacks(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Lacks);
  const auto* lacks = check.root<wire::Lacks>(payload);
  if (lacks == nullptr) return check.error();
  return check.finish(Lacks{idsOf(check, lacks->ids(), kMaxLacks, "ids")});
}

Result<Keep> decodeKeep(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Keep);
  const auto* keep = check.root<wire::Keep>(payload);
  if (keep == nullptr) return check.error();
  return Keep{bytesOf(keep->leaves())};
}

Result<Poses> decodePoses(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Poses);
  const auto* wirePoses = check.root<wire::Poses>(payload);
  if (wirePoses == nullptr) return check.error();
  Result<std::vector<Pose>> poses = decodePoseBytes(bytesOf(wirePoses->poses()));
  if (!poses) return poses.error();
  return Poses{std::move(*poses)};
}

Result<Shown> decodeShown(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Shown);
  const auto* wireShown = check.root<wire::Shown>(payload);
  if (wireShown == nullptr) return check.error();
  Shown shown = {.frame = check.frameNumber(wireShown->frame()),
                 .shownNs = wireShown->shown_ns(),
                 .picture = std::nullopt};
  if (wireShown->picture() != nullptr) shown.picture = pictureOf(check, *wireShown->picture());
  return check.finish(shown);
}

}  // namespace tessera::proto
