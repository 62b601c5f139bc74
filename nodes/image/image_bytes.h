// Images as bytes, for nodes that make a picture in bands of rows (node.h, "Shards"). A node with
// several pictures puts one after the other into each piece, and stacks each by itself.
#pragma once
#include <vector>

#include "image/image.h"
#include "runtime/bytes.h"

namespace weft {

void put_image(ByteWriter& to, const Image& image);
Image take_image(ByteReader& from);  // throws Error

// Bands from top to bottom, of the same width and channels.
class ImageStack {
  public:
    void add(Image band);  // throws Error if it does not go with those before
    Image whole();         // with the colour space, view and attributes of the first

  private:
    std::vector<Image> bands_;
    int height_ = 0;
};

}  // namespace weft
