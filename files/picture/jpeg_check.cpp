#include "files/picture/jpeg_check.h"

#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>
// libjpeg's codes of its messages, by their names.
#include <jerror.h>

namespace firn {
namespace {

constexpr double kMaxPixels = 268435456.0;  // as the decoder of pictures admits

struct Complaints {
  jpeg_error_mgr manager;
  std::jmp_buf leave;
  bool decoding = false;  ///< the head is read; stray bytes in it, as some cameras write, are no damage
  char first[JMSG_LENGTH_MAX] = "";
};

Complaints& of(j_common_ptr jpeg) { return *reinterpret_cast<Complaints*>(jpeg->err); }

void keep(j_common_ptr jpeg) {
  if (Complaints& c = of(jpeg); c.first[0] == '\0') c.manager.format_message(jpeg, c.first);
}

void warn(j_common_ptr jpeg, int level) {
  if (level >= 0) return;  // traces
  if (const Complaints& c = of(jpeg); !c.decoding && c.manager.msg_code == JWRN_EXTRANEOUS_DATA) return;
  keep(jpeg);
}

void give_up(j_common_ptr jpeg) {
  keep(jpeg);
  std::longjmp(of(jpeg).leave, 1);
}

void say_nothing(j_common_ptr) {}

}  // namespace

std::string damage_of_jpeg(std::span<const unsigned char> file) {
  jpeg_decompress_struct jpeg;
  Complaints complaints;
  jpeg.err = jpeg_std_error(&complaints.manager);
  complaints.manager.emit_message = &warn;
  complaints.manager.error_exit = &give_up;
  complaints.manager.output_message = &say_nothing;
  if (setjmp(complaints.leave) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return complaints.first;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, file.data(), static_cast<unsigned long>(file.size()));
  jpeg_read_header(&jpeg, TRUE);
  if (double(jpeg.image_width) * jpeg.image_height <= kMaxPixels) {
    complaints.decoding = true;
    jpeg.scale_num = 1;
    jpeg.scale_denom = 8;
    jpeg.dct_method = JDCT_IFAST;
    jpeg_start_decompress(&jpeg);
    // Its own memory, so that nothing of ours is left behind when it gives up.
    const JSAMPARRAY row = jpeg.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&jpeg), JPOOL_IMAGE,
                                                  jpeg.output_width * JDIMENSION(jpeg.output_components), 1);
    while (jpeg.output_scanline < jpeg.output_height) jpeg_read_scanlines(&jpeg, row, 1);
    jpeg_finish_decompress(&jpeg);
  }
  jpeg_destroy_decompress(&jpeg);
  return complaints.first;
}

}  // namespace firn
