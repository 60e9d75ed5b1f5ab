// Poses a mesh whose bones have axes of their own.
#pragma once

#include "CoreMinimal.h"
#include "LiveLinkRetargetAsset.h"
#include "MotionSpliceRetargetAsset.generated.h"

/**
 * The retarget asset of a "Live Link Pose" node for a subject of motionsplice. Bones of the mesh are found by name. A
 * bone of the bank is aligned with the world in the bind pose; a bone of a mesh has the axes that its modeller gave it.
 */
UCLASS(Blueprintable)
class MOTIONSPLICE_API UMotionSpliceRetargetAsset : public ULiveLinkRetargetAsset
{
	GENERATED_BODY()

public:
	/** Direction in which the mesh faces in its own axes, degrees: 90 for Y, as glTF is imported, and 0 for X. */
	UPROPERTY(EditAnywhere, Category = "motionsplice")
	double MeshYaw = 90.0;

	virtual void BuildPoseFromAnimationData(float DeltaTime, const FLiveLinkSkeletonStaticData* InSkeletonData,
		const FLiveLinkAnimationFrameData* InFrameData, FCompactPose& OutPose) override;
};
