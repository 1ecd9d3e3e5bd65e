// The only file that includes OpenCV. Built as a module that nothing links: see opencv_module.hpp.
#include "calibration/opencv_module.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/mcc.hpp>

#include <array>
#include <exception>
#include <vector>

namespace {

// mcc's model of the chart: patches of 2.5 with gaps of 0.25 and the same margin, 16.75 x 11.25 in all.
const std::vector<cv::Point2f> kModelBox{{0.0f, 0.0f}, {16.75f, 0.0f}, {16.75f, 11.25f}, {0.0f, 11.25f}};
const std::vector<cv::Point2f> kModelCorners{{1.5f, 1.5f}, {15.25f, 1.5f}, {15.25f, 9.75f}, {1.5f, 9.75f}};

}  // namespace

extern "C" __attribute__((visibility("default"))) int aluminate_find_charts_v1(const std::uint8_t* bgr,
                                                                               int width, int height,
                                                                               int most,
                                                                               float* quadrilaterals) {
  try {
    const cv::Mat picture(height, width, CV_8UC3, const_cast<std::uint8_t*>(bgr));
    const cv::Ptr<cv::mcc::CCheckerDetector> detector = cv::mcc::CCheckerDetector::create();
    if (!detector->process(picture.clone(), cv::mcc::MCC24, most)) return 0;
    int count = 0;
    for (const cv::Ptr<cv::mcc::CChecker>& chart : detector->getListColorChecker()) {
      const std::vector<cv::Point2f> box = chart->getBox();
      if (box.size() != 4 || count == most) continue;
      std::vector<cv::Point2f> corners;
      cv::perspectiveTransform(kModelCorners, corners, cv::getPerspectiveTransform(kModelBox, box));
      for (const cv::Point2f& corner : corners) {
        *quadrilaterals++ = corner.x;
        *quadrilaterals++ = corner.y;
      }
      ++count;
    }
    return count;
  } catch (const std::exception&) {
    return -1;
  }
}
