// crc16_ccitt computes CRC-16/CCITT-FALSE byte by byte: begin with CRC16_BEGIN; "123456789" has 29B1.
#ifndef FIRN_FIRMWARE_CRC16_H
#define FIRN_FIRMWARE_CRC16_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { CRC16_BEGIN = 0xFFFF };

uint16_t crc16_ccitt(uint16_t crc, uint8_t byte);

#ifdef __cplusplus
}
#endif

#endif
