#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <osg/Geometry>

#include "client/offscreen_surface.h"
#include "client/tile_cache.h"
#include "client/tile_view.h"
#include "common/assets/asset_id.h"
#include "common/image/picture.h"
#include "common/scene/osgb_codec.h"

namespace tessera::test {

inline constexpr std::uint32_t kSceneLeaves = 40;

/// Coloured triangles all over the image rectangle of testFrame(), some in front of others.
inline osg::ref_ptr<osg::Geometry> triangles(std::uint32_t seed) {
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array, normals = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec4Array> colours = new osg::Vec4Array;
  const auto next = [&] {
    seed = seed * 1664525U + 1013904223U;
    return static_cast<float>(seed >> 8U) / static_cast<float>(1U << 24U);
  };
  const osg::Vec3 middle(4 * next() - 2, 3 * next() - 1.5F, -next());
  for (int i = 0; i < 3; ++i) {
    vertices->push_back(middle + osg::Vec3(2 * next() - 1, 2 * next() - 1, next() / 4));
    normals->push_back(osg::Vec3(0, 0, 1));
    colours->push_back(osg::Vec4(next(), next(), next(), 1));
  }
  geometry->setVertexArray(vertices);
  geometry->setNormalArray(normals, osg::Array::BIND_PER_VERTEX);
  geometry->setColorArray(colours, osg::Array::BIND_PER_VERTEX);
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
  geometry->setUseDisplayList(false);
  geometry->setUseVertexBufferObjects(true);
  return geometry;
}

inline void addScene(TileCache& cache) {
  const OsgbCodec codec;
  const auto add = [&](const osg::Object& object, proto::AssetKind kind) {
    const std::string text = codec.write(object).value();
    const auto bytes = std::as_bytes(std::span(text));
    const AssetId id = assetIdOf(bytes);
    EXPECT_TRUE(cache.add(proto::Assets{{{id.bytes, kind, bytes}}}).ok());
    return id.bytes;
  };
  const proto::Sha256 state = add(*osg::ref_ptr<osg::StateSet>(new osg::StateSet), proto::AssetKind::State);
  for (std::uint32_t i = 0; i < kSceneLeaves; ++i) {
    proto::Leaves leaves;
    proto::LeafRecord& leaf = leaves.leaves.emplace_back();
    leaf.id = i;
    leaf.drawable = add(*triangles(i + 1), proto::AssetKind::Drawable);
    leaf.state = state;
    leaf.radius = 10;
    EXPECT_TRUE(cache.add(leaves, kSceneLeaves).ok());
  }
}

/// The image rectangle is 4 x 3 m around the origin, the eye 3 m before it.
inline proto::Frame testFrame(double eyeX = 0) {
  proto::Frame frame;
  frame.frame = 1;
  frame.eye = {eyeX, 0, 3};
  frame.corners = {Vec3(-2, -1.5, 0), Vec3(2, -1.5, 0), Vec3(2, 1.5, 0), Vec3(-2, 1.5, 0)};
  frame.nearM = 0.5;
  frame.farM = 20;
  return frame;
}

inline proto::Welcome welcomeOf(int widthPx, int heightPx) {
  proto::Welcome welcome;
  welcome.wallName = "wall";
  welcome.tileName = "r0c0";
  welcome.widthPx = welcome.wallWidthPx = widthPx;
  welcome.heightPx = welcome.wallHeightPx = heightPx;
  welcome.leafCount = kSceneLeaves;
  welcome.backgroundRgb = {0.2F, 0.4F, 0.6F};
  return welcome;
}

/// A tile as the program has it, drawing by OSMesa, without a master.
class OsMesaTile {
 public:
  explicit OsMesaTile(const proto::Welcome& welcome)
      : OsMesaTile(welcome, PixelSize{welcome.widthPx, welcome.heightPx}) {}
  /// Drawn in another size, as by a window.
  OsMesaTile(const proto::Welcome& welcome, PixelSize drawn)
      : drawn_(drawn), surface_(surfaces_->make({welcome.tileName, drawn}).value()) {
    const Status status = surface_->makeCurrent();
    EXPECT_TRUE(status.ok()) << (status ? "" : status.error().text());
    view_ = std::make_unique<TileView>(welcome, surface_->drawnSize());
    addScene(cache_);
    view_->setList({{0, kSceneLeaves}}, cache_, false);
  }
  OsMesaTile(int widthPx, int heightPx) : OsMesaTile(welcomeOf(widthPx, heightPx)) {}
  ~OsMesaTile() {
    EXPECT_TRUE(surface_->makeCurrent().ok());
    view_.reset();
  }
  OsMesaTile(const OsMesaTile&) = delete;
  OsMesaTile& operator=(const OsMesaTile&) = delete;

  Status configure(const proto::TileSetup& setup) {
    EXPECT_TRUE(surface_->makeCurrent().ok());
    return view_->configure(setup);
  }

  Status tryDraw(const proto::Frame& frame, const OverlayFacts& facts = {}) {
    EXPECT_TRUE(surface_->makeCurrent().ok());
    return view_->draw(frame, facts);
  }

  Picture draw(const proto::Frame& frame, const OverlayFacts& facts = {}) {
    const Status status = tryDraw(frame, facts);
    EXPECT_TRUE(status.ok()) << (status ? "" : status.error().text());
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    surface_->finish();
    Picture picture(drawn_.widthPx, drawn_.heightPx);
    picture.rgb = surface_->readPicture();
    return picture;
  }

 private:
  const PixelSize drawn_;
  const std::unique_ptr<SurfaceMaker> surfaces_ = makeOffscreenSurfaces();
  std::unique_ptr<Surface> surface_;
  TileCache cache_{TileCache::Options{}};
  std::unique_ptr<TileView> view_;
};

/// The picture of a setup on a tile of its own.
inline Picture drawn(int widthPx, int heightPx, const proto::TileSetup& setup,
                     const proto::Frame& frame = testFrame()) {
  OsMesaTile tile(widthPx, heightPx);
  const Status status = tile.configure(setup);
  EXPECT_TRUE(status.ok()) << (status ? "" : status.error().text());
  return tile.draw(frame);
}

inline int channelAt(const Picture& picture, int x, int y, int channel) {
  const auto index = (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.widthPx) +
                      static_cast<std::size_t>(x)) *
                         3 +
                     static_cast<std::size_t>(channel);
  return picture.rgb[index];
}

/// Different values in the picture: a blank one would pass many a comparison.
inline std::size_t coloursIn(const Picture& picture) {
  std::vector<std::array<std::uint8_t, 3>> all(picture.rgb.size() / 3);
  std::memcpy(all.data(), picture.rgb.data(), picture.rgb.size());
  std::sort(all.begin(), all.end());
  return static_cast<std::size_t>(std::unique(all.begin(), all.end()) - all.begin());
}

}  // namespace tessera::test
