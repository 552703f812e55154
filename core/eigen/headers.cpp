// Empty: cmake/StillframeHeaders.cmake.
