#pragma once
#include "CoreMinimal.h"

struct FCompactPose;
struct FLiveLinkAnimationFrameData;
struct FLiveLinkSkeletonStaticData;

class ULiveLinkRetargetAsset : public UObject
{
	GENERATED_BODY()

	virtual void BuildPoseFromAnimationData(
		float, const FLiveLinkSkeletonStaticData*, const FLiveLinkAnimationFrameData*, FCompactPose&)
	{
	}
};
