#include <pinch/version.h>

#define TEXT_OF(number) #number
#define TEXT(number)    TEXT_OF(number)

const char *pinch_version(void)
{
    return TEXT(PINCH_VERSION_MAJOR) "." TEXT(PINCH_VERSION_MINOR) "." TEXT(PINCH_VERSION_PATCH);
}
