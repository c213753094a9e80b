#include "render/picture/frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

TEST(Frame, StartsInOneColour) {
  const picture::Colour colour{1, 2, 3, 4};
  const picture::Frame frame = picture::makeFrame({3, 2}, colour);
  EXPECT_EQ(frame.pixels.size(), 24U);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) EXPECT_EQ(frame.at(x, y), colour);
  }
}

TEST(Frame, PastesAtTheGivenCorner) {
  picture::Frame sheet = picture::makeFrame({5, 4}, {0, 0, 0});
  picture::pasteFrame(sheet, picture::makeFrame({2, 1}, {9, 9, 9}), 2, 3);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) {
      const bool pasted = y == 3 && (x == 2 || x == 3);
      EXPECT_EQ(sheet.at(x, y), (pasted ? picture::Colour{9, 9, 9} : picture::Colour{0, 0, 0}))
          << x << ' ' << y;
    }
  }
}

TEST(Frame, IsOpaqueUnlessOnePixelIsNot) {
  picture::Frame frame = picture::makeFrame({2, 2}, {0, 0, 0});
  EXPECT_TRUE(picture::isOpaque(frame));
  frame.set(1, 1, {0, 0, 0, 254});
  EXPECT_FALSE(picture::isOpaque(frame));
}

TEST(Frame, RefusesSizesOutOfRange) {
  for (const picture::FrameSize size :
       {picture::FrameSize{0, 720}, {-3, 720}, {1280, 0}, {1280, 16385}}) {
    try {
      picture::requireValidSize(size);
      ADD_FAILURE() << size.width << " x " << size.height;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()),
                "error: a picture of " + std::to_string(size.width) + " x " +
                    std::to_string(size.height) +
                    " pixels cannot be drawn; width and height may be 1 to 16384, for example "
                    "--size 1280x720");
    }
  }
  EXPECT_NO_THROW(picture::requireValidSize({1, 16384}));
}

}  // namespace
}  // namespace kirireel
