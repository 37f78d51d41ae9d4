// Addresses of IPv4, the first byte highest.
#ifndef SEAM_OPEN_R_IP_ADDRESS_H
#define SEAM_OPEN_R_IP_ADDRESS_H

#include <antTypes.h>

typedef uint16 Port;
#define IP_PORT_ANY 0

struct IPAddress {
  IPAddress() : address(0) {}
  IPAddress(uint32 a) : address(a) {}
  IPAddress(int a) : address(static_cast<uint32>(a)) {}
  IPAddress(byte a, byte b, byte c, byte d)
      : address(static_cast<uint32>(a) << 24 | static_cast<uint32>(b) << 16 |
                static_cast<uint32>(c) << 8 | d) {}
  IPAddress(const char* text);  // "127.0.0.1"; another text is 0.0.0.0.

  boolean operator==(const IPAddress& a) const { return address == a.address; }
  boolean operator!=(const IPAddress& a) const { return address != a.address; }
  boolean operator<(const IPAddress& a) const { return address < a.address; }
  uint32 Address() const { return address; }
  boolean InLoop() const { return address >> 24 == 127; }
  char* GetAsString(char* text) const;  // 16 bytes.

 private:
  uint32 address;
};

const IPAddress IP_ADDR_ANY;
const IPAddress IP_ADDR_BROADCAST(0xffffffffu);

inline std::ostream& operator<<(std::ostream& stream, const IPAddress& a) {
  char text[16];
  return stream << a.GetAsString(text);
}

#endif
