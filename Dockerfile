# lpslam as a user without a home:
#   docker build -t lpslam . && docker run --rm -v "$PWD:/data" lpslam info map.lpmap
FROM python:3.12-slim
# RealSense's library loads libusb; leave both out where there is no camera. `simulate` and `demo` set letters by FriBiDi.
RUN apt-get update && apt-get install -y --no-install-recommends libusb-1.0-0 libfribidi0 && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN pip install --no-cache-dir '/src[phones,azure,realsense]' && rm -rf /src
# Kernels are compiled for the processor that builds the image; on another kind they are compiled at the first start.
ENV NUMBA_CACHE_DIR=/var/cache/lpslam
RUN mkdir -p "$NUMBA_CACHE_DIR" && chown 65534:65534 "$NUMBA_CACHE_DIR"
USER 65534:65534
RUN python -c "from lpslam.slam.warm_up import warm_up; warm_up(print)"
WORKDIR /data
ENTRYPOINT ["lpslam"]
