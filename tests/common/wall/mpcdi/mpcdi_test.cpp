#include "common/wall/mpcdi/mpcdi.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/base/file.h"
#include "common/wall/mpcdi/archive.h"
#include "common/wall/mpcdi/maps.h"
#include "common/wall/mpcdi/warp_mesh.h"
#include "tests/support/mpcdi_archive.h"
#include "tests/support/process.h"

namespace tessera {
namespace {

using test::pfm;
using test::png;
using test::Sample;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << "the test's text has no \"" << from << '"';
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

class MpcdiFile : public testing::Test {
 protected:
  using Files = std::map<std::string, std::string>;

  /// Two blended regions; the left one's map has a hole and is little-endian, the right one's big-endian.
  static Files twoRegions() {
    const auto warp = [](int column, int row) {
      return Sample{static_cast<float>(column) / 9, 1 - static_cast<float>(row) / 4, 0.5F};
    };
    Files files;
    files["mpcdi.xml"] = test::twoRegions2d();
    files["left.pfm"] = pfm(10, 5, [&](int c, int r) {
      return c == 3 && r == 1 ? Sample{kNan, kNan, kNan} : warp(c, r);
    });
    files["right.pfm"] = pfm(10, 5, warp, /*isLittleEndian=*/false);
    files["maps/left.png"] =
        png(4, 3, 1, 8, false, [](int x, int y, int) { return std::uint16_t(x * 1000 + y * 10000); });
    files["right.png"] =
        png(4, 3, 3, 16, false, [](int x, int y, int c) { return std::uint16_t(x * 100 + y * 10 + c); });
    files["beta.png"] =
        png(5, 5, 1, 16, true, [](int x, int y, int) { return std::uint16_t(x * 7 + y * 1000); });
    return files;
  }

  Result<Mpcdi> read(const Files& files) {
    const std::string path = folder_ / "a.mpcdi";
    test::writeArchive(path, files);
    return readMpcdi(path);
  }

  std::string errorOf(const Files& files) {
    const Result<Mpcdi> mpcdi = read(files);
    return mpcdi ? "no error" : mpcdi.error().text();
  }

  std::string errorOfXml(std::string_view from, std::string_view to) {
    Files files = twoRegions();
    files["mpcdi.xml"] = replaced(files["mpcdi.xml"], from, to);
    return errorOf(files);
  }

  test::TemporaryFolder folder_;
};

TEST_F(MpcdiFile, holdsRegionsAndTheirMaps) {
  const Result<Mpcdi> mpcdi = read(twoRegions());
  ASSERT_TRUE(mpcdi.ok()) << mpcdi.error().text();
  EXPECT_EQ(mpcdi->profile, MpcdiProfile::Media2d);
  EXPECT_EQ(mpcdi->version, "1.0");
  ASSERT_EQ(mpcdi->buffers.size(), 1u);
  EXPECT_EQ(mpcdi->buffers[0].id, "front");
  EXPECT_EQ(mpcdi->buffers[0].widthPx, 300);
  ASSERT_EQ(mpcdi->regions.size(), 2u);
  const MpcdiRegion& left = mpcdi->regions[0];
  const MpcdiRegion& right = mpcdi->regions[1];
  EXPECT_EQ(left.id, "left");
  EXPECT_EQ(left.buffer, "front");
  EXPECT_EQ(left.widthPx, 180);
  EXPECT_EQ(left.heightPx, 100);
  EXPECT_EQ(right.x, 0.4);
  EXPECT_EQ(right.y, 0.25);
  EXPECT_EQ(right.width, 0.6);
  EXPECT_EQ(right.height, 0.5);
  for (const MpcdiRegion* region : {&left, &right}) {
    ASSERT_TRUE(region->warp.has_value());
    EXPECT_EQ(region->warp->columns, 10);
    EXPECT_EQ(region->warp->rows, 5);
    ASSERT_EQ(region->warp->xyz.size(), 150u);
    for (int row = 0; row < 5; ++row) {
      for (int column = 0; column < 10; ++column) {
        const float* xyz = region->warp->xyz.data() + 3 * (row * 10 + column);
        if (region == &left && column == 3 && row == 1) {
          EXPECT_TRUE(std::isnan(xyz[0]));
          continue;
        }
        EXPECT_EQ(xyz[0], static_cast<float>(column) / 9);
        EXPECT_EQ(xyz[1], 1 - static_cast<float>(row) / 4) << "rows come from the bottom in the file";
        EXPECT_EQ(xyz[2], 0.5F);
      }
    }
  }
  EXPECT_EQ(left.alpha.widthPx, 4);
  EXPECT_EQ(left.alpha.heightPx, 3);
  EXPECT_DOUBLE_EQ(left.alpha.gammaEmbedded, 2.2);
  EXPECT_EQ(right.alpha.gammaEmbedded, 1);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      const auto i = static_cast<std::size_t>(y * 4 + x);
      const int high = (x * 1000 + y * 10000) >> 8;
      EXPECT_EQ(left.alpha.values[i], high * 257) << "8 bits spread over 16";
      EXPECT_EQ(right.alpha.values[i], x * 100 + y * 10 + 1) << "the mean of three channels";
    }
  }
  ASSERT_EQ(left.beta.values.size(), 25u);
  EXPECT_EQ(left.beta.values[5 * 3 + 2], 2 * 7 + 3 * 1000) << "interlaced";
  EXPECT_TRUE(right.beta.isEmpty());
  EXPECT_TRUE(mpcdi->warnings.empty());
}

TEST_F(MpcdiFile, holdsFrustaAndFrames) {
  Files files;
  files["mpcdi.xml"] = R"(<MPCDI profile="3d" version="2.0"><display><buffer id="b">
    <region id="r" xResolution="100" yResolution="50" x="0" y="0" xSize="1" ySize="1">
      <frustum><yaw>-54.5</yaw><pitch>30</pitch><roll> 1e1 </roll>
        <rightAngle>26.5</rightAngle><leftAngle>-26.25</leftAngle><upAngle>20</upAngle><downAngle>-10</downAngle></frustum>
      <coordinateFrame><posx>1</posx><posy>2</posy><posz>3</posz><yawx>0</yawx><yawy>0</yawy><yawz>-1</yawz>
        <pitchx>1</pitchx><pitchy>0</pitchy><pitchz>0</pitchz><rollx>0</rollx><rolly>1</rolly><rollz>0</rollz></coordinateFrame>
      <color/>
    </region></buffer></display><extensionSet/><extensionSet/></MPCDI>)";
  const Result<Mpcdi> mpcdi = read(files);
  ASSERT_TRUE(mpcdi.ok()) << mpcdi.error().text();
  const MpcdiRegion& region = mpcdi->regions[0];
  ASSERT_TRUE(region.frustum && region.frame);
  EXPECT_EQ(region.frustum->yawDeg, -54.5);
  EXPECT_EQ(region.frustum->pitchDeg, 30);
  EXPECT_EQ(region.frustum->rollDeg, 10);
  EXPECT_EQ(region.frustum->leftDeg, -26.25);
  EXPECT_EQ(region.frustum->rightDeg, 26.5);
  EXPECT_EQ(region.frustum->downDeg, -10);
  EXPECT_EQ(region.frustum->upDeg, 20);
  EXPECT_EQ(region.frame->position, Vec3(1, 2, 3));
  EXPECT_EQ(region.frame->rollAxis, Vec3(0, 1, 0));
  ASSERT_EQ(mpcdi->warnings.size(), 2u);
  EXPECT_TRUE(contains(mpcdi->warnings[0], "(mpcdi.xml):7: color: not used"));
  EXPECT_TRUE(contains(mpcdi->warnings[1], ":8: extensionSet: "));
}

TEST_F(MpcdiFile, pointsInSpaceComeInMetres) {
  Files files;
  files["MPCDI.XML"] = R"(<MPCDI profile="sl" version="1.0"><display><buffer id="b">
    <region id="r" Xresolution="100" Yresolution="50" x="0" y="0" xsize="1" ysize="1"/></buffer></display>
    <files><fileset region="r"><geometryWarpFile><path>p.pfm</path><geometricUnit>cm</geometricUnit>
      <originOf3DData>floorCenter</originOf3DData></geometryWarpFile>
      <distortionMap><path>none.pfm</path></distortionMap></fileset></files></MPCDI>)";
  files["p.pfm"] = pfm(2, 1, [](int c, int) { return Sample{100.F * float(c), 50, -200}; });
  const Result<Mpcdi> mpcdi = read(files);
  ASSERT_TRUE(mpcdi.ok()) << mpcdi.error().text();
  const MpcdiWarp& warp = *mpcdi->regions[0].warp;
  EXPECT_TRUE(warp.isInSpace);
  EXPECT_EQ(warp.origin, MpcdiWarp::Origin::FloorCenter);
  EXPECT_NEAR(warp.xyz[3], 1, 1e-6);
  EXPECT_NEAR(warp.xyz[5], -2, 1e-6);
  EXPECT_TRUE(contains(mpcdi->warnings.at(0), "distortionMap"));
  files["MPCDI.XML"] = replaced(files["MPCDI.XML"], "cm", "parsec");
  EXPECT_TRUE(contains(errorOf(files), ":3: the geometricUnit is none of mm"));
}

TEST_F(MpcdiFile, readsTheMapsOfOneRegionAlone) {
  Files files = twoRegions();
  files["right.pfm"] = "damaged";
  const std::string path = folder_ / "a.mpcdi";
  test::writeArchive(path, files);
  const Result<Mpcdi> left = readMpcdi(path, "left");
  ASSERT_TRUE(left.ok()) << left.error().text();
  EXPECT_TRUE(left->regions.at(0).warp.has_value());
  EXPECT_FALSE(left->regions.at(1).warp.has_value());
  EXPECT_TRUE(left->regions.at(1).alpha.isEmpty());
  EXPECT_FALSE(readMpcdi(path, "right").ok());
  EXPECT_TRUE(contains(readMpcdi(path, "middle").error().text(), "has no region \"middle\""));
}

TEST_F(MpcdiFile, saysWhatIsWrongWithTheDescription) {
  EXPECT_TRUE(
      contains(errorOfXml("profile=\"2d\"", "profile=\"4d\""), "a.mpcdi(mpcdi.xml):2: the profile \"4d\""));
  EXPECT_TRUE(contains(errorOfXml("version=\"1.0\">", "version=\"3.0\">"), "version \"3.0\" is not known"));
  EXPECT_TRUE(contains(errorOfXml("Xresolution=\"180\"", ""), ":5: \"xresolution\" must be a number"));
  EXPECT_TRUE(contains(errorOfXml("Xresolution=\"180\"", "Xresolution=\"180.5\""), "whole number"));
  EXPECT_TRUE(contains(errorOfXml("Xresolution=\"180\"", "Xresolution=\"20000\""), ":5: \"xresolution\""));
  EXPECT_TRUE(contains(errorOfXml("xsize=\"0.6\"", "xsize=\"nan\""), "\"xsize\""));
  EXPECT_TRUE(contains(errorOfXml("xsize=\"0.6\"", "xsize=\"0\""), "\"xsize\""));
  EXPECT_TRUE(
      contains(errorOfXml("id=\"right\"", "id=\"left\""), ":6: a second region has the id of another"));
  EXPECT_TRUE(contains(errorOfXml("id=\"right\"", "id=\"\""), "1 to 256 bytes"));
  EXPECT_TRUE(contains(errorOfXml("region=\"right\"", "region=\"other\""), "files for the region \"other\""));
  EXPECT_TRUE(contains(errorOfXml("<path>left.pfm</path>", ""), "lacks <path>"));
  EXPECT_TRUE(contains(errorOfXml("<path>left.pfm</path>", "<path>gone.pfm</path>"),
                       "a.mpcdi(gone.pfm): the archive has no such file"));
  EXPECT_TRUE(contains(errorOfXml("<path>left.pfm</path>", "<path>../left.pfm</path>"),
                       "no name of a file in the archive"));
  EXPECT_TRUE(contains(errorOfXml("<path>left.pfm</path>", "<path>/etc/passwd</path>"),
                       "no name of a file in the archive"));
  EXPECT_TRUE(
      contains(errorOfXml("<path>left.pfm</path>", "<path>a\\b</path>"), "no name of a file in the archive"));
  EXPECT_TRUE(
      contains(errorOfXml("<path>left.pfm</path>", "<path>right.png</path>"), "no portable float map"));
  EXPECT_TRUE(contains(errorOfXml("<path>right.png</path>", "<path>left.pfm</path>"),
                       "a.mpcdi(left.pfm): is no usable PNG"));
  EXPECT_TRUE(contains(errorOfXml("2.2", "1000"), "\"gammaEmbedded\" must be"));
  EXPECT_TRUE(contains(errorOfXml("</MPCDI>", ""), "is no XML"));
  EXPECT_TRUE(contains(errorOfXml("<MPCDI profile", "<!DOCTYPE x [<!ENTITY a \"b\">]><MPCDI profile"),
                       "document type"));
  EXPECT_TRUE(contains(errorOfXml("profile=\"2d\"", "profile=\"3d\""), "profile 3d lacks <frustum>"));
  Files files = twoRegions();
  files.erase("mpcdi.xml");
  EXPECT_TRUE(contains(errorOf(files), "without mpcdi.xml"));
  files["mpcdi.xml"] = "<MPCDI profile=\"2d\" version=\"1.0\"><display/></MPCDI>";
  EXPECT_TRUE(contains(errorOf(files), "describes no region"));
}

TEST_F(MpcdiFile, bounds) {
  Files files = twoRegions();
  files["mpcdi.xml"] += std::string(std::size_t{1} << 20, ' ');
  EXPECT_TRUE(contains(errorOf(files), "(mpcdi.xml): holds more than 1048576 bytes"));
  // A bomb: 400 MiB of zeros in less than one.
  files = twoRegions();
  files["left.pfm"] = "PF\n10 5\n-1\n" + std::string(std::size_t{385} << 20, '\0');
  EXPECT_TRUE(contains(errorOf(files), "(left.pfm): holds more than "));
  files = twoRegions();
  std::string regions;
  for (int i = 0; i < 257; ++i)
    regions += "<region id=\"r" + std::to_string(i) +
               "\" Xresolution=\"1\" Yresolution=\"1\" x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\"/>";
  files["mpcdi.xml"] = replaced(files["mpcdi.xml"], "</buffer>", regions + "</buffer>");
  EXPECT_TRUE(contains(errorOf(files), "more than 256 regions"));
  files = twoRegions();
  for (int i = 0; i < 4096; ++i)
    files["f" + std::to_string(i)] = "";
  EXPECT_TRUE(contains(errorOf(files), "more than 4096 files"));
}

TEST_F(MpcdiFile, mapsTogetherAreBounded) {
  // Every region names the same large map, of 5000 x 5000 samples of nothing.
  Files files;
  std::string regions, sets;
  for (int i = 0; i < 5; ++i) {
    const std::string id = "r" + std::to_string(i);
    regions += "<region id=\"" + id +
               "\" Xresolution=\"1\" Yresolution=\"1\" x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\"/>";
    sets += "<fileset region=\"" + id + "\"><geometryWarpFile><path>m</path></geometryWarpFile></fileset>";
  }
  files["mpcdi.xml"] = "<MPCDI profile=\"2d\" version=\"1.0\"><display><buffer id=\"b\">" + regions +
                       "</buffer></display><files>" + sets + "</files></MPCDI>";
  files["m"] = "PF\n5000 5000\n-1\n" + std::string(std::size_t{5000} * 5000 * 12, '\0');
  EXPECT_TRUE(contains(errorOf(files), "holds more than ")) << errorOf(files);
}

TEST_F(MpcdiFile, filesThatAreNoArchives) {
  EXPECT_TRUE(contains(readMpcdi(folder_ / "none").error().text(), "no file that can be read"));
  EXPECT_TRUE(contains(readMpcdi(folder_.path()).error().text(), "no file that can be read"));
  EXPECT_TRUE(contains(readMpcdi(folder_.write("e", "")).error().text(), "no sound zip archive"));
  EXPECT_TRUE(contains(readMpcdi(folder_.write("t", "PK, but text")).error().text(), "no sound zip archive"));
}

TEST_F(MpcdiFile, everyTruncationIsAnError) {
  const std::string path = folder_ / "whole";
  test::writeArchive(path, twoRegions());
  const Result<std::string> bytes = readFile(path, 1 << 20);
  ASSERT_TRUE(bytes.ok());
  for (std::size_t size = 0; size < bytes->size(); size += size + 64 < bytes->size() ? 7 : 1)
    EXPECT_FALSE(readMpcdi(folder_.write("cut", bytes->substr(0, size))).ok()) << size;
}

TEST_F(MpcdiFile, damageIsAnErrorOrHarmless) {
  const std::string path = folder_ / "whole";
  test::writeArchive(path, twoRegions());
  const Result<std::string> bytes = readFile(path, 1 << 20);
  ASSERT_TRUE(bytes.ok());
  int errors = 0, trials = 0;
  for (std::size_t i = 0; i < bytes->size(); i += 3) {
    std::string damaged = *bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    ++trials;
    const Result<Mpcdi> mpcdi = readMpcdi(folder_.write("damaged", damaged));
    if (!mpcdi) {
      ++errors;
      continue;
    }
    for (const MpcdiRegion& region : mpcdi->regions)
      (void)warpMeshOf(region, 0.5);
  }
  EXPECT_GT(errors, trials / 2) << "checksums find most of it";
}

TEST(MpcdiMaps, floatMapHeaders) {
  const auto errorOf = [](const std::string& bytes) {
    const Result<MpcdiWarp> warp = parsePfm(bytes, "m");
    return warp ? "no error" : warp.error().text();
  };
  const std::string data(12, '\0');
  EXPECT_EQ(errorOf("PF\n1 1\n-1\n" + data), "no error");
  EXPECT_EQ(errorOf("PF 1\n1 -1.000000\n" + data), "no error");
  EXPECT_EQ(errorOf("PF\r\n1 1\r\n-1\n" + data), "no error");
  EXPECT_TRUE(contains(errorOf("Pf\n1 1\n-1\n" + data), "three channels"));
  EXPECT_TRUE(contains(errorOf("PF"), "three channels"));
  EXPECT_TRUE(contains(errorOf("PF\n1\n"), "says no size"));
  EXPECT_TRUE(contains(errorOf("PF\n-1 1\n-1\n" + data), "has -1 x 1 samples"));
  EXPECT_TRUE(contains(errorOf("PF\n0 1\n-1\n" + data), "has 0 x 1 samples"));
  EXPECT_TRUE(contains(errorOf("PF\n16384 16384\n-1\n" + data), "has 16384 x 16384 samples"));
  EXPECT_TRUE(contains(errorOf("PF\n99999999999999999999 1\n-1\n" + data), "says no size"));
  EXPECT_TRUE(contains(errorOf("PF\n4000000000 4000000000\n-1\n" + data), "samples"));
  EXPECT_TRUE(contains(errorOf("PF\n1 1\n0\n" + data), "byte order"));
  EXPECT_TRUE(contains(errorOf("PF\n1 1\nnan\n" + data), "byte order"));
  EXPECT_TRUE(contains(errorOf("PF\n1 1\n-1\n" + data + "x"), "holds 13 bytes of samples; 1 x 1 need 12"));
  EXPECT_TRUE(contains(errorOf("PF\n1 1\n-1\n" + data.substr(1)), "holds 11 bytes"));
  EXPECT_TRUE(contains(errorOf("PF\n" + std::string(300, ' ') + "1 1\n-1\n" + data), "says no size"));
}

TEST(MpcdiMaps, valuesWithoutBoundsAreHoles) {
  const Result<MpcdiWarp> warp = parsePfm(pfm(3, 1,
                                              [](int c, int) {
                                                const float values[3] = {INFINITY, -1e30F, 2};
                                                return Sample{values[c], 0, 0};
                                              }),
                                          "m");
  ASSERT_TRUE(warp.ok());
  EXPECT_TRUE(std::isnan(warp->xyz[0]));
  EXPECT_TRUE(std::isnan(warp->xyz[3]));
  EXPECT_EQ(warp->xyz[6], 2);
}

TEST(MpcdiMaps, picturesAreBoundedBeforeTheyAreDecoded) {
  // A header that claims 100000 x 100000 pixels.
  std::string bytes = png(4, 4, 1, 8, false, [](int, int, int) { return std::uint16_t{0}; });
  bytes.replace(16, 8, std::string("\0\x01\x86\xa0\0\x01\x86\xa0", 8));
  const Result<MpcdiMap> map = parsePngMap(bytes, "m");
  ASSERT_FALSE(map.ok());
  EXPECT_TRUE(contains(map.error().text(), "m: is no usable PNG picture"));
  const std::string whole = png(8, 8, 3, 8, true, [](int x, int, int) { return std::uint16_t(x << 8); });
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parsePngMap(std::string_view(whole).substr(0, size), "m").ok()) << size;
}

}  // namespace
}  // namespace tessera
