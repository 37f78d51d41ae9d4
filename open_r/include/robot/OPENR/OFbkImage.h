// One band of a layer of an image. The lines of the bands take turns: Y, Cr, Cb of the first line,
// then of the second. The last line is no picture: it carries a counter and how often each colour
// was detected.
#ifndef SEAM_OPEN_R_OFBK_IMAGE_H
#define SEAM_OPEN_R_OFBK_IMAGE_H

#include <OPENR/ODataFormats.h>

typedef longword OFbkImageBand;
const OFbkImageBand ofbkimageBAND_Y = 0;
const OFbkImageBand ofbkimageBAND_Cr = 1;
const OFbkImageBand ofbkimageBAND_Cb = 2;
const OFbkImageBand ofbkimageBAND_CDT = 3;
const OFbkImageBand ofbkimageBAND_Y_LH = 4;
const OFbkImageBand ofbkimageBAND_Y_HL = 5;
const OFbkImageBand ofbkimageBAND_Y_HH = 6;

class OFbkImage {
 public:
  OFbkImage(OFbkImageInfo* info, byte* data, OFbkImageBand band);

  bool IsValid() const { return image_ != 0; }
  byte* Pointer() const { return image_; }
  int Width() const { return width_; }
  int Height() const { return height_; }
  int Skip() const { return skip_; }  // Bytes from a line's end to the next line.
  byte Pixel(int x, int y) const { return image_[(width_ + skip_) * y + x]; }
  word FieldCounter() const;
  byte ColorFrequency(OCdtChannel channel) const;  // Pixels / 16.

 private:
  const byte* last_line() const { return image_ + (width_ + skip_) * (height_ - 1); }

  byte* image_;
  int width_, height_, skip_;
};

#endif
