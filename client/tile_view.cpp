#include "client/tile_view.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include <Eigen/Geometry>
#include <osg/Depth>
#include <osg/Light>
#include <osg/LightModel>
#include <osg/Material>
#include <osgUtil/CullVisitor>

#include "client/leaf_box.h"

namespace tessera {

namespace {

osg::Matrixd toOsg(const Mat4& m) {
  osg::Matrixd out;
  Eigen::Map<Mat4>(out.ptr()) = m;  // see toColumnVectors in common/scene/extract.cpp
  return out;
}

/// A light from a direction of the world (y up); the same for all tiles, so that seams do not show.
osg::ref_ptr<osg::Light> directionalLight(int number, const osg::Vec3& to, const osg::Vec4& diffuse,
                                          float specular) {
  osg::ref_ptr<osg::Light> light = new osg::Light(static_cast<unsigned int>(number));
  osg::Vec3 direction = to;
  direction.normalize();
  light->setPosition(osg::Vec4(direction, 0));
  light->setAmbient(osg::Vec4(0, 0, 0, 1));
  light->setDiffuse(diffuse);
  light->setSpecular(osg::Vec4(specular, specular, specular, 1));
  return light;
}

/// What OSG assumes of a scene that says nothing: lit, colours from the vertices, normals scaled as needed.
osg::ref_ptr<osg::StateSet> defaultState() {
  osg::ref_ptr<osg::StateSet> state = new osg::StateSet;
  state->setMode(GL_LIGHTING, osg::StateAttribute::ON);
  state->setMode(GL_LIGHT0, osg::StateAttribute::ON);
  state->setMode(GL_LIGHT1, osg::StateAttribute::ON);
  state->setMode(GL_NORMALIZE, osg::StateAttribute::ON);
  state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
  osg::ref_ptr<osg::LightModel> model = new osg::LightModel;
  model->setAmbientIntensity(osg::Vec4(0.40F, 0.42F, 0.46F, 1));
  model->setTwoSided(true);
  state->setAttributeAndModes(model);
  osg::ref_ptr<osg::Material> material = new osg::Material;
  material->setColorMode(osg::Material::AMBIENT_AND_DIFFUSE);
  state->setAttributeAndModes(material);
  state->setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0.0, 1.0));
  return state;
}

}  // namespace

/// The visible leaves as one node of the scene graph. Its traversal hands each leaf straight to the cull
/// visitor's render bins, ordered by state and then by id: an order that does not depend on which other
/// leaves a tile sees, so that surfaces which coincide are resolved alike on all tiles.
class LeafListNode : public osg::Node {
 public:
  LeafListNode() {
    setCullingActive(false);
    setStateSet(defaultState());
    sun_ = directionalLight(0, osg::Vec3(0.45F, 0.80F, 0.40F), osg::Vec4(0.72F, 0.69F, 0.63F, 1), 0.35F);
    fill_ = directionalLight(1, osg::Vec3(-0.60F, 0.25F, -0.55F), osg::Vec4(0.16F, 0.18F, 0.22F, 1), 0);
  }

  void setList(const VisibleList& list, TileCache& cache, bool drawsBoxes) {
    leaves_.clear();
    boxes_.clear();
    forEachLeaf(list, [&](std::uint32_t id) {
      CachedLeaf* leaf = cache.find(id);
      if (!leaf) return;
      if (leaf->canBeDrawn()) {
        leaves_.emplace_back(leaf->stateRank, id, leaf);
      } else if (drawsBoxes) {
        boxes_.push_back(leaf);
      }
    });
    std::sort(leaves_.begin(), leaves_.end());
  }

  /// `rotation`: world axes to the eye's.
  void setEye(const Vec3& eye, const Mat3& rotation) { eye_ = eye, rotation_ = rotation; }

  osg::BoundingSphere computeBound() const override { return osg::BoundingSphere(osg::Vec3(), 1); }

  void accept(osg::NodeVisitor& visitor) override {
    if (visitor.getVisitorType() != osg::NodeVisitor::CULL_VISITOR) return;
    auto* cull = dynamic_cast<osgUtil::CullVisitor*>(&visitor);
    if (!cull) return;
    cull->pushStateSet(getStateSet());
    const auto eyeAxes = new osg::RefMatrix(toOsg(rotationOnly()));
    cull->addPositionedAttribute(eyeAxes, sun_);
    cull->addPositionedAttribute(eyeAxes, fill_);
    const osg::StateSet* current = nullptr;
    for (const auto& [rank, id, leaf] : leaves_) {
      if (leaf->state.get() != current) {
        if (current) cull->popStateSet();
        cull->pushStateSet(leaf->state);
        current = leaf->state;
      }
      add(*cull, *leaf);
    }
    if (current) cull->popStateSet();
    for (CachedLeaf* leaf : boxes_)
      addBox(*cull, *leaf);
    cull->popStateSet();
  }

 private:
  [[nodiscard]] Mat4 rotationOnly() const {
    Mat4 m = Mat4::Identity();
    m.topLeftCorner<3, 3>() = rotation_;
    return m;
  }

  void addBox(osgUtil::CullVisitor& cull, CachedLeaf& leaf) const {
    Mat4 relative = boxToWorld(leaf);
    relative.col(3).head<3>() -= eye_;
    const double depth = -(rotation_.row(2) * (leaf.boxCenter - eye_))(0);
    cull.addDrawableAndDepth(&boxOf(leaf), new osg::RefMatrix(toOsg(rotationOnly() * relative)),
                             static_cast<float>(depth));
  }

  void add(osgUtil::CullVisitor& cull, const CachedLeaf& leaf) const {
    if (!leaf.canBeDrawn()) return;
    if (leaf.deformer) leaf.deformer->apply();
    Mat4 relative = leaf.localToWorld;
    relative.col(3).head<3>() -= eye_;
    const Mat4 modelview = rotationOnly() * relative;
    osg::ref_ptr<osg::RefMatrix> matrix = new osg::RefMatrix(toOsg(modelview));
    if (leaf.billboard) {
      const osg::Vec3d eyeLocal = osg::Vec3d(0, 0, 0) * osg::Matrixd::inverse(*matrix);
      leaf.billboard->computeMatrix(*matrix, eyeLocal, leaf.billboardPosition);
    }
    const double depth = -(rotation_.row(2) * (leaf.center - eye_))(0);
    cull.addDrawableAndDepth(leaf.drawable, matrix, static_cast<float>(depth));
  }

  std::vector<std::tuple<std::uint32_t, std::uint32_t, const CachedLeaf*>> leaves_;
  std::vector<CachedLeaf*> boxes_;  ///< of leaves that cannot be drawn yet
  osg::ref_ptr<osg::Light> sun_, fill_;
  Vec3 eye_ = Vec3::Zero();
  Mat3 rotation_ = Mat3::Identity();
};

TileView::TileView(const proto::Welcome& welcome, PixelSize drawn)
    : window_{welcome.xPx,      welcome.yPx,         welcome.widthPx,
              welcome.heightPx, welcome.wallWidthPx, welcome.wallHeightPx},
      drawn_(drawn),
      leaves_(new LeafListNode) {
  viewer_.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
  viewer_.setUseConfigureAffinity(false);  // else every tile process would pin itself to the same core
  viewer_.setUpViewerAsEmbeddedInWindow(0, 0, drawn.widthPx, drawn.heightPx);
  viewer_.setLightingMode(osg::View::NO_LIGHT);
  osg::Camera& camera = *viewer_.getCamera();
  camera.setClearColor(
      osg::Vec4(welcome.backgroundRgb[0], welcome.backgroundRgb[1], welcome.backgroundRgb[2], 1));
  camera.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  camera.setCullingMode(osg::CullSettings::NO_CULLING);
  camera.setViewMatrix(osg::Matrixd::identity());
  GLint limits[2] = {0, 0};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, limits);
  wallViewportFits_ = window_.wallWidthPx <= limits[0] && window_.wallHeightPx <= limits[1];
  viewer_.setSceneData(leaves_);
  viewer_.realize();
  const unsigned int context = camera.getGraphicsContext()->getState()->getContextID();
  output_.emplace(welcome, drawn_, osg::GLExtensions::Get(context, true));
}

TileView::~TileView() = default;

void TileView::setList(const VisibleList& list, TileCache& cache, bool drawsBoxes) {
  leaves_->setList(list, cache, drawsBoxes);
}

Status TileView::configure(const proto::TileSetup& setup) {
  return output_->configure(setup);
}

bool TileView::fillsWindow(const PixelArea& area) const {
  return area == PixelArea{0, 0, drawn_.widthPx, drawn_.heightPx};
}

Status TileView::draw(const proto::Frame& frame, const OverlayFacts& facts) {
  const auto views = eyeViews(frame, drawn_.widthPx, drawn_.heightPx);
  if (!views) return views.error();
  for (const EyeView& view : *views) {
    selectBuffer(view.buffer);
    if (frame.pattern == proto::Pattern::None) {
      drawScene(frame, view);
    } else if (Status status = output_->drawPattern(frame.pattern, view.area); !status) {
      return status;
    }
    output_->correct(view.area);
    if (!frame.overlay) continue;
    if (Status status = output_->drawOverlay(facts, view.area); !status) return status;
  }
  return Done{};
}

void TileView::selectBuffer(GLenum buffer) {
  // After frames with a buffer for each eye, one picture is for both.
  if (buffer == GL_NONE && buffer_ != GL_NONE) buffer = GL_BACK;
  if (buffer == buffer_) return;
  buffer_ = buffer;
  glDrawBuffer(buffer);
  glReadBuffer(buffer);
  viewer_.getCamera()->setDrawBuffer(buffer);
  viewer_.getCamera()->setReadBuffer(buffer);
}

/// What is drawn to, and cleared before: OpenSceneGraph clears the whole viewport, which
/// may be the wall's, so for half a window this is done here.
void TileView::setTarget(const EyeView& view) {
  osg::Camera& camera = *viewer_.getCamera();
  const bool isWhole = fillsWindow(view.area);
  camera.setClearMask(isWhole ? GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT : 0);
  osg::StateSet& state = *leaves_->getStateSet();
  if (isWhole) {
    if (scissor_) state.removeAttribute(scissor_);
    scissor_ = nullptr;
    return;
  }
  scissor_ = new osg::Scissor(view.area.xPx, view.area.yPx, view.area.widthPx, view.area.heightPx);
  state.setAttributeAndModes(scissor_);
  glPushAttrib(GL_ALL_ATTRIB_BITS);
  glScissor(view.area.xPx, view.area.yPx, view.area.widthPx, view.area.heightPx);
  glEnable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  const osg::Vec4 colour = camera.getClearColor();
  glClearColor(colour.r(), colour.g(), colour.b(), colour.a());
  glClearDepth(1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glPopAttrib();
}

void TileView::drawScene(const proto::Frame& frame, const EyeView& view) {
  Mat3 rotation;
  rotation.row(0) = frame.right.transpose();
  rotation.row(1) = frame.up.transpose();
  rotation.row(2) = frame.right.cross(frame.up).transpose();  // towards the eye
  leaves_->setEye(view.eye, rotation);
  setTarget(view);
  setProjection(frame, view, rotation);
  viewer_.frame();
}

void TileView::setProjection(const proto::Frame& frame, const EyeView& view, const Mat3& rotation) {
  // The image rectangle on the near plane.
  const Vec3 lowerLeft = rotation * (view.corners[0] - view.eye);
  const Vec3 upperRight = rotation * (view.corners[2] - view.eye);
  const double toNearLeft = frame.nearM / -lowerLeft.z(), toNearRight = frame.nearM / -upperRight.z();
  double left = lowerLeft.x() * toNearLeft, right = upperRight.x() * toNearRight;
  double bottom = lowerLeft.y() * toNearLeft, top = upperRight.y() * toNearRight;
  // The wall's viewport, squeezed as the view is; OpenGL counts rows from below. It must lie on whole pixels.
  const PixelArea& area = view.area;
  const double scaleX = static_cast<double>(area.widthPx) / window_.widthPx;
  const double scaleY = static_cast<double>(area.heightPx) / window_.heightPx;
  const double wall[] = {area.xPx - window_.xPx * scaleX,
                         area.yPx - (window_.wallHeightPx - window_.yPx - window_.heightPx) * scaleY,
                         window_.wallWidthPx * scaleX, window_.wallHeightPx * scaleY};
  const bool isOnPixels =
      std::all_of(std::begin(wall), std::end(wall), [](double px) { return px == std::floor(px); });
  osg::Camera& camera = *viewer_.getCamera();
  if (!wallViewportFits_ || !isOnPixels) {
    camera.setViewport(area.xPx, area.yPx, area.widthPx, area.heightPx);
  } else {
    camera.setViewport(new osg::Viewport(wall[0], wall[1], wall[2], wall[3]));
    // From the tile's rectangle to the wall's. The rounding is that of doubles, so all tiles arrive at the
    // same floats.
    const double pixelX = (right - left) / window_.widthPx, pixelY = (top - bottom) / window_.heightPx;
    left -= window_.xPx * pixelX;
    right = left + window_.wallWidthPx * pixelX;
    top += window_.yPx * pixelY;
    bottom = top - window_.wallHeightPx * pixelY;
  }
  camera.setProjectionMatrixAsFrustum(left, right, bottom, top, frame.nearM, frame.farM);
}

}  // namespace tessera
