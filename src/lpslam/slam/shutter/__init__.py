"""Rolling shutters: how keypoints are straightened, and how the readout is learned."""
