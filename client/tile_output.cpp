#include "client/tile_output.h"

#include <algorithm>
#include <utility>

namespace tessera {

namespace {

constexpr float kOverlayOpacity = 0.65F;
constexpr double kPixelM = 0.001;  // where nobody says

TilePlace placeOf(const proto::Welcome& welcome) {
  const double left = welcome.xPx, right = left + welcome.widthPx;
  const double top = welcome.wallHeightPx - welcome.yPx, bottom = top - welcome.heightPx;
  TilePlace place{.tileName = welcome.tileName,
                  .screenName = welcome.wallName,
                  .widthPx = welcome.widthPx,
                  .heightPx = welcome.heightPx,
                  .screenWidthM = welcome.wallWidthPx * kPixelM,
                  .screenHeightM = welcome.wallHeightPx * kPixelM,
                  .cornersM = {Vec2(left, bottom), Vec2(right, bottom), Vec2(right, top), Vec2(left, top)}};
  for (Vec2& corner : place.cornersM)
    corner *= kPixelM;
  return place;
}

/// The part of `area` in which a picture lies that would be `widthPx` x `heightPx` large in the upper left of
/// a whole picture. The area is a whole picture or one that was squeezed into half.
PixelArea upperLeftOf(const PixelArea& area, const TilePlace& whole, int widthPx, int heightPx) {
  const int width = std::max(1, widthPx * area.widthPx / whole.widthPx);
  const int height = std::max(1, heightPx * area.heightPx / whole.heightPx);
  return {area.xPx, area.yPx + area.heightPx - height, width, height};
}

}  // namespace

TileOutput::TileOutput(const proto::Welcome& welcome, PixelSize drawn, osg::ref_ptr<osg::GLExtensions> gl)
    : gl_(std::move(gl)), drawn_(drawn), place_(placeOf(welcome)) {}

Status TileOutput::configure(const proto::TileSetup& setup) {
  place_.screenName = setup.screenName;
  place_.screenWidthM = setup.screenWidthM;
  place_.screenHeightM = setup.screenHeightM;
  place_.cornersM = setup.cornersM;
  pattern_ = proto::Pattern::None;
  pass_.reset();
  if (!OutputPass::isNeeded(setup)) return Done{};
  auto pass = OutputPass::make(*gl_, setup, {place_.widthPx, place_.heightPx}, drawn_);
  if (!pass) return pass.error();
  pass_ = std::move(*pass);
  return Done{};
}

Status TileOutput::make(std::unique_ptr<GlPicture>& picture) const {
  if (picture) return Done{};
  auto made = GlPicture::make(*gl_);
  if (!made) return made.error();
  picture = std::move(*made);
  return Done{};
}

Status TileOutput::drawPattern(proto::Pattern pattern, const PixelArea& area) {
  if (pattern_ != pattern) {
    if (Status status = make(patternPicture_); !status) return status;
    const bool isIdentify = pattern == proto::Pattern::Identify;
    const Picture picture = isIdentify ? identifyPattern(place_) : alignmentPattern(place_);
    if (Status status = patternPicture_->upload(picture); !status) return status;
    pattern_ = pattern;
  }
  patternPicture_->draw(area);
  return Done{};
}

void TileOutput::correct(const PixelArea& area) const {
  if (pass_) pass_->apply(area);
}

Status TileOutput::drawOverlay(const OverlayFacts& facts, const PixelArea& area) {
  if (Status status = make(overlayPicture_); !status) return status;
  const Picture picture = overlayPicture(overlayLines(facts), place_.heightPx);
  if (Status status = overlayPicture_->upload(picture); !status) return status;
  overlayPicture_->draw(upperLeftOf(area, place_, picture.widthPx, picture.heightPx), kOverlayOpacity);
  return Done{};
}

}  // namespace tessera
